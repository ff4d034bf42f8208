// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace poise::geometry {

/// The number whose bytes begin at `bytes`, in that order.
template <class Number>
Number number_of_bytes(const char* bytes, bool big_end_first) {
  static_assert(std::is_arithmetic_v<Number> && std::endian::native == std::endian::little);
  char turned[sizeof(Number)];
  if (big_end_first) {
    for (std::size_t i = 0; i < sizeof(Number); ++i) turned[i] = bytes[sizeof(Number) - 1 - i];
    bytes = turned;
  }
  Number value{};
  std::memcpy(&value, bytes, sizeof(Number));
  return value;
}

/// Reads bytes from the front and never beyond their end.
class ByteCursor {
 public:
  explicit ByteCursor(std::string_view bytes) : bytes_(bytes) {}
  [[nodiscard]] bool has(std::size_t count) const { return count <= bytes_.size() - at_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  [[nodiscard]] std::size_t at() const { return at_; }
  /// has(count) must hold.
  const char* take(std::size_t count) {
    const char* taken = bytes_.data() + at_;
    at_ += count;
    return taken;
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace poise::geometry
