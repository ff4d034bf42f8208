// SPDX-License-Identifier: MIT
#include "assets/mesh/gltf_bytes.h"

#include <array>
#include <cstdint>

#include <fmt/format.h>

#include "assets/files/text_cursor.h"
#include "assets/mesh/byte_cursor.h"

namespace poise::geometry {
namespace {

constexpr std::string_view kContainerMagic = "glTF";
constexpr std::size_t kContainerHeadBytes = 20;
constexpr std::size_t kChunkContainerHeadBytes = 8;
constexpr std::uint8_t kNoDigit = 0xff;

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  return number_of_bytes<std::uint32_t>(bytes.data() + at, false);
}

constexpr std::array<std::uint8_t, 256> kDigits = [] {
  std::array<std::uint8_t, 256> digits{};
  digits.fill(kNoDigit);
  constexpr std::string_view kInOrder = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kInOrder.size(); ++i)
    digits[static_cast<unsigned char>(kInOrder[i])] = static_cast<std::uint8_t>(i);
  return digits;
}();

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char low = static_cast<char>(c | 0x20);
  return low >= 'a' && low <= 'f' ? low - 'a' + 10 : -1;
}

}  // namespace

Result<GltfParts> split_gltf(std::string_view bytes) {
  if (!bytes.starts_with(kContainerMagic)) return GltfParts{without_byte_order_mark(bytes), {}};
  if (bytes.size() < kContainerHeadBytes) return bad_input("GLB: ends within its header");
  const std::uint32_t version = number_at(bytes, 4);
  if (version != 1 && version != 2) return bad_input(fmt::format("GLB: version {}, must be 1 or 2", version));
  const std::size_t length = number_at(bytes, 12);
  if (length > bytes.size() - kContainerHeadBytes)
    return bad_input(
        fmt::format("GLB: {} bytes of JSON are announced in {} bytes, must have room", length, bytes.size()));
  const GltfParts parts{bytes.substr(kContainerHeadBytes, length), bytes.substr(kContainerHeadBytes + length)};
  if (version == 1) return parts;
  // Version 2 has chunks; the second one, if present, is the binary part.
  if (parts.binary.size() < kChunkContainerHeadBytes) return GltfParts{parts.text, {}};
  const std::size_t size = number_at(parts.binary, 0);
  if (size > parts.binary.size() - kChunkContainerHeadBytes)
    return bad_input(fmt::format("GLB: its binary part of {} bytes is cut off", size));
  return GltfParts{parts.text, parts.binary.substr(kChunkContainerHeadBytes, size)};
}

std::string decoded_uri(std::string_view part) {
  std::string bytes;
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (part[i] == '%' && i + 2 < part.size() && hex_digit(part[i + 1]) >= 0 && hex_digit(part[i + 2]) >= 0) {
      bytes += static_cast<char>(16 * hex_digit(part[i + 1]) + hex_digit(part[i + 2]));
      i += 2;
    } else {
      bytes += part[i];
    }
  }
  return bytes;
}

Result<std::string> data_of_uri(std::string_view uri) {
  constexpr std::string_view kBase64 = ";base64,";
  const std::size_t at = uri.substr(0, 200).find(kBase64);
  if (at == std::string_view::npos) return bad_input("data in a uri must begin with data:TYPE;base64,");
  std::string_view digits = uri.substr(at + kBase64.size());
  std::string decoded;
  if (digits.find('%') != std::string_view::npos) digits = decoded = decoded_uri(digits);
  while (digits.ends_with('=')) digits.remove_suffix(1);
  std::string bytes;
  bytes.reserve(digits.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const std::uint8_t digit = kDigits[static_cast<unsigned char>(digits[i])];
    if (digit == kNoDigit) return bad_input(fmt::format("digit {} of a uri's data is none of base64", i));
    bits = bits << 6U | digit;
    // Four digits are three bytes; two or three digits at the end are one or two.
    if (i % 4 != 0) bytes += static_cast<char>(bits >> (6 - 2 * (i % 4)) & 0xffU);
  }
  return bytes;
}

}  // namespace poise::geometry
