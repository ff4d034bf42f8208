// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/broad_phase/near_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>

#include "collision/broad_phase/near_kernel.h"

#ifndef POISE_NEAR_KERNEL_SET_BITS
#define POISE_NEAR_KERNEL_SET_BITS
namespace poise::collision {
namespace {

constexpr std::size_t kAtOnce = 8;

// For each byte the numbers of its set bits, ascending.
constexpr auto kSetBits = [] {
  std::array<std::array<std::uint8_t, kAtOnce>, 256> set{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::size_t count = 0;
    for (std::uint8_t bit = 0; bit < kAtOnce; ++bit) {
      if ((byte >> bit & 1U) != 0) set[byte][count++] = bit;
    }
  }
  return set;
}();

}  // namespace
}  // namespace poise::collision
#endif

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

NearCount list_near_balls(const NearBalls& balls, const NearBall& ball, std::span<const NearRange> ranges,
                          std::uint32_t* list) {
  const hn::CappedTag<float, kAtOnce> d;
  const hn::RebindToUnsigned<decltype(d)> places;
  const hn::Rebind<std::uint8_t, decltype(d)> bytes;
  constexpr auto kLanes = static_cast<std::uint32_t>(hn::MaxLanes(d));
  const NearBalls from = balls;
  const auto x = hn::Set(d, ball.x);
  const auto y = hn::Set(d, ball.y);
  const auto z = hn::Set(d, ball.z);
  const auto most = hn::Set(d, ball.most_m);
  const auto least = hn::Set(d, ball.least_m);
  const auto bits_of = [&](auto mask) HWY_ATTR {
    std::uint8_t stored[8] = {};
    hn::StoreMaskBits(d, mask, stored);
    return std::uint32_t{stored[0]};
  };
  std::size_t listed = 0;
  std::uint32_t unsure = 0;
  for (const NearRange& range : ranges) {
    const auto tag = hn::Set(places, range.tag);
    for (std::uint32_t e = range.begin; e < range.end; e += kLanes) {
      const auto dx = hn::Sub(hn::LoadU(d, from.x + e), x);
      const auto dy = hn::Sub(hn::LoadU(d, from.y + e), y);
      const auto dz = hn::Sub(hn::LoadU(d, from.z + e), z);
      const auto reach = hn::Add(hn::LoadU(d, from.most_m + e), most);
      const auto sure_reach = hn::Max(hn::Add(hn::LoadU(d, from.least_m + e), least), hn::Zero(d));
      const auto square = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      const auto same = hn::RebindMask(d, hn::Eq(hn::LoadU(places, from.tag + e), tag));
      const std::uint32_t inside = (1U << std::min(range.end - e, kLanes)) - 1U;
      const std::uint32_t near = inside & bits_of(hn::And(same, hn::Lt(square, hn::Mul(reach, reach))));
      unsure |= near & ~bits_of(hn::Lt(square, hn::Mul(sure_reach, sure_reach)));
      // The places of the set bits, read from a table: no branch depends on how many there are.
      const auto set = hn::PromoteTo(places, hn::LoadU(bytes, kSetBits[near].data()));
      hn::StoreU(hn::Add(set, hn::Set(places, e)), places, list + listed);
      listed += static_cast<std::size_t>(std::popcount(near));
    }
  }
  return {listed, unsure == 0};
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {

HWY_EXPORT(list_near_balls);

NearCount list_near(const NearBalls& balls, const NearBall& ball, std::span<const NearRange> ranges,
                    std::uint32_t* list) {
  return HWY_DYNAMIC_DISPATCH(list_near_balls)(balls, ball, ranges, list);
}

}  // namespace poise::collision
#endif
