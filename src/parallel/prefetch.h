// SPDX-License-Identifier: MIT
#pragma once

#include <hwy/base.h>
#include <hwy/cache_control.h>

#include <cstddef>

namespace poise::parallel {

/// About so many pairs, at 800 bytes each, fit into the second cache of a core: with fewer nothing is prefetched, which
/// would take instructions and save no time. Chosen.
inline constexpr std::size_t kPairsAtHand = 1024;

/// Prefetches all cache lines of an object that is read some objects later, where these lie anywhere in memory.
///
/// Whatever calls it must be inline too (HWY_INLINE, or a lambda): GCC takes a function that only prefetches for one
/// without effect, and leaves out its calls.
template <class T>
HWY_INLINE void prefetch(const T& object) {
  constexpr std::size_t kLine = 64;
  const auto* bytes = reinterpret_cast<const std::byte*>(&object);
  for (std::size_t at = 0; at < sizeof(T); at += kLine) hwy::Prefetch(bytes + at);
  // One that begins within a line may reach into another.
  if constexpr ((sizeof(T) - 1) % kLine >= alignof(T)) hwy::Prefetch(bytes + sizeof(T) - 1);
}

}  // namespace poise::parallel
