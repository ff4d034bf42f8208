// SPDX-License-Identifier: MIT
// Vectors of three in the lanes of a register, and the figures of several bodies read into lanes. Read once for each
// instruction set, by a file that Highway compiles so; hence the guard that turns over instead of staying.
#if defined(POISE_SOLVER_LANE_MATH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef POISE_SOLVER_LANE_MATH_INL_H
#undef POISE_SOLVER_LANE_MATH_INL_H
#else
#define POISE_SOLVER_LANE_MATH_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "solver/contact_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Multiplications and additions stay apart: fused ones would round differently from one instruction set to the next.

// Three numbers in each lane.
template <class V>
struct Triple {
  V x, y, z;
};

template <class D, class T>
HWY_INLINE Triple<hn::Vec<D>> load(D d, const T (*from)[kLanes], std::size_t lane) {
  return {hn::Load(d, from[0] + lane), hn::Load(d, from[1] + lane), hn::Load(d, from[2] + lane)};
}
template <class D, class V, class T>
HWY_INLINE void store(D d, const Triple<V>& value, T (*to)[kLanes], std::size_t lane) {
  hn::Store(value.x, d, to[0] + lane);
  hn::Store(value.y, d, to[1] + lane);
  hn::Store(value.z, d, to[2] + lane);
}
template <class V>
HWY_INLINE V dot(const Triple<V>& a, const Triple<V>& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class V>
HWY_INLINE Triple<V> sum(const Triple<V>& a, const Triple<V>& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <class V>
HWY_INLINE Triple<V> difference(const Triple<V>& a, const Triple<V>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class V>
HWY_INLINE Triple<V> scaled(const V& by, const Triple<V>& a) {
  return {hn::Mul(by, a.x), hn::Mul(by, a.y), hn::Mul(by, a.z)};
}
template <class V>
HWY_INLINE Triple<V> cross(const Triple<V>& a, const Triple<V>& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

// Four figures of as many bodies as there are lanes.
template <class V>
struct Columns {
  V at[4];
};

// The figures from `offset` on of the structures of `bodies`, which begin with numbers of type T, one after another.
template <class D, class S>
HWY_INLINE Columns<hn::Vec<D>> gather_singly(D d, const S* of, const std::uint32_t* bodies, std::size_t offset) {
  using T = hn::TFromD<D>;
  alignas(64) T at[4][kLanes];
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    const T* const row = reinterpret_cast<const T*>(of + bodies[lane]) + offset;
    for (std::size_t k = 0; k < 4; ++k) at[k][lane] = row[k];
  }
  return {{hn::Load(d, at[0]), hn::Load(d, at[1]), hn::Load(d, at[2]), hn::Load(d, at[3])}};
}

// The way back, for the bodies that yield.
template <class D, class S>
HWY_INLINE void scatter_singly(D d, const Columns<hn::Vec<D>>& from, std::uint32_t dynamic, S* of,
                               const std::uint32_t* bodies, std::size_t offset) {
  using T = hn::TFromD<D>;
  alignas(64) T at[4][kLanes];
  for (std::size_t k = 0; k < 4; ++k) hn::Store(from.at[k], d, at[k]);
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    if ((dynamic >> lane & 1U) == 0) continue;
    T* const row = reinterpret_cast<T*>(of + bodies[lane]) + offset;
    for (std::size_t k = 0; k < 4; ++k) row[k] = at[k][lane];
  }
}

#if HWY_TARGET == HWY_SCALAR
template <class D, class S>
HWY_INLINE Columns<hn::Vec<D>> gather(D d, const S* of, const std::uint32_t* bodies, std::size_t offset) {
  return gather_singly(d, of, bodies, offset);
}
template <class D, class S>
HWY_INLINE void scatter(D d, const Columns<hn::Vec<D>>& from, std::uint32_t dynamic, S* of, const std::uint32_t* bodies,
                        std::size_t offset) {
  scatter_singly(d, from, dynamic, of, bodies, offset);
}
#else
template <class D>
HWY_INLINE Columns<hn::Vec<D>> transposed(D d, const Columns<hn::Vec<D>>& rows) {
  const hn::RepartitionToWide<hn::RebindToUnsigned<D>> wide;
  const auto low = [&](const auto& a, const auto& b)
                       HWY_ATTR { return hn::BitCast(wide, hn::InterleaveLower(d, a, b)); };
  const auto up = [&](const auto& a, const auto& b)
                      HWY_ATTR { return hn::BitCast(wide, hn::InterleaveUpper(d, a, b)); };
  const auto ab_low = low(rows.at[0], rows.at[1]);
  const auto ab_up = up(rows.at[0], rows.at[1]);
  const auto cd_low = low(rows.at[2], rows.at[3]);
  const auto cd_up = up(rows.at[2], rows.at[3]);
  return {{hn::BitCast(d, hn::InterleaveLower(wide, ab_low, cd_low)),
           hn::BitCast(d, hn::InterleaveUpper(wide, ab_low, cd_low)),
           hn::BitCast(d, hn::InterleaveLower(wide, ab_up, cd_up)),
           hn::BitCast(d, hn::InterleaveUpper(wide, ab_up, cd_up))}};
}

// Four bodies at a time: their figures are read whole and transposed in registers.
template <class D, class S>
HWY_INLINE Columns<hn::Vec<D>> gather(D d, const S* of, const std::uint32_t* bodies, std::size_t offset) {
  using T = hn::TFromD<D>;
  if constexpr (sizeof(T) == sizeof(float)) {
    const hn::FixedTag<T, 4> four;
    const auto row = [&](std::size_t lane)
                         HWY_ATTR { return hn::Load(four, reinterpret_cast<const T*>(of + bodies[lane]) + offset); };
    const auto first = transposed(four, {{row(0), row(1), row(2), row(3)}});
    if constexpr (hn::MaxLanes(D()) == 8) {
      const auto second = transposed(four, {{row(4), row(5), row(6), row(7)}});
      return {{hn::Combine(d, second.at[0], first.at[0]), hn::Combine(d, second.at[1], first.at[1]),
               hn::Combine(d, second.at[2], first.at[2]), hn::Combine(d, second.at[3], first.at[3])}};
    } else {
      return first;
    }
  } else {
    return gather_singly(d, of, bodies, offset);
  }
}
template <class D, class S>
HWY_INLINE void scatter(D d, const Columns<hn::Vec<D>>& from, std::uint32_t dynamic, S* of, const std::uint32_t* bodies,
                        std::size_t offset) {
  using T = hn::TFromD<D>;
  if constexpr (sizeof(T) == sizeof(float)) {
    const hn::FixedTag<T, 4> four;
    using Four = Columns<hn::Vec<decltype(four)>>;
    const auto quad = [&](const Four& columns, std::size_t lane) HWY_ATTR {
      const Four rows = transposed(four, columns);
      for (std::size_t k = 0; k < 4; ++k) {
        if ((dynamic >> (lane + k) & 1U) != 0)
          hn::Store(rows.at[k], four, reinterpret_cast<T*>(of + bodies[lane + k]) + offset);
      }
    };
    if constexpr (hn::MaxLanes(D()) == 8) {
      quad(Four{{hn::LowerHalf(four, from.at[0]), hn::LowerHalf(four, from.at[1]), hn::LowerHalf(four, from.at[2]),
                 hn::LowerHalf(four, from.at[3])}},
           0);
      quad(Four{{hn::UpperHalf(four, from.at[0]), hn::UpperHalf(four, from.at[1]), hn::UpperHalf(four, from.at[2]),
                 hn::UpperHalf(four, from.at[3])}},
           4);
    } else {
      quad(from, 0);
    }
  } else {
    scatter_singly(d, from, dynamic, of, bodies, offset);
  }
}
#endif

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
