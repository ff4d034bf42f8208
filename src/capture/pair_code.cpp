// SPDX-License-Identifier: MIT
#include "capture/pair_code.h"

#include "capture/bytes.h"

namespace poise::capture {

void put_pairs(std::uint64_t frame, std::span<const PackedPair> pairs, std::string& out) {
  const std::size_t begin = out.size();
  put(std::uint32_t{0}, out);
  put(frame, out);
  put_varint(pairs.size(), out);
  std::int64_t before = 0;
  for (const PackedPair& pair : pairs) {
    put_zigzag(pair.a - before, out);
    before = pair.a;
  }
  for (const PackedPair& pair : pairs) put_zigzag(std::int64_t{pair.b} - pair.a, out);
  for (const auto column : {&PackedPair::state, &PackedPair::level, &PackedPair::deepest, &PackedPair::seen,
                            &PackedPair::error, &PackedPair::outcome, &PackedPair::turn}) {
    for (const PackedPair& pair : pairs) out.push_back(static_cast<char>(pair.*column));
  }
  std::string bytes;
  put(static_cast<std::uint32_t>(out.size() - begin - sizeof(std::uint32_t)), bytes);
  out.replace(begin, bytes.size(), bytes);
}

}  // namespace poise::capture
