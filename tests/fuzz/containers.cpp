// SPDX-License-Identifier: MIT
#include "fuzz/containers.h"

#include <xxhash.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>

namespace poise::fuzz {
namespace {

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

}  // namespace

std::string with_record_checksums(std::string_view bytes) {
  constexpr std::size_t kHead = 9, kTail = 4;
  std::string whole(bytes);
  std::size_t at = whole.find('\n') + 1;
  while (at + kHead + kTail <= whole.size()) {
    const std::size_t stored = number_at(whole, at + 5);
    if (stored > whole.size() - at - kHead - kTail) break;
    const auto sum =
        static_cast<std::uint32_t>(::crc32_z(0, reinterpret_cast<const Bytef*>(whole.data() + at), kHead + stored));
    std::memcpy(whole.data() + at + kHead + stored, &sum, sizeof sum);
    at += kHead + stored + kTail;
  }
  return whole;
}

std::string with_entry_checksum(std::string_view bytes) {
  constexpr std::size_t kKeyAt = 32, kSum = 16;
  std::string whole(bytes);
  if (whole.size() < kKeyAt + 2 * kSum) return whole;
  whole.replace(kKeyAt, kSum, kSum, '\0');
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits(whole.data(), whole.size() - kSum));
  std::memcpy(whole.data() + whole.size() - kSum, canonical.digest, kSum);
  return whole;
}

}  // namespace poise::fuzz
