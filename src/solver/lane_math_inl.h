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
// Four rows of four numbers turned into columns, or columns into rows.
template <class D>
HWY_INLINE Columns<hn::Vec<D>> transposed(D d, const Columns<hn::Vec<D>>& rows) {
  const auto ab_low = hn::InterleaveLower(d, rows.at[0], rows.at[1]);
  const auto ab_up = hn::InterleaveUpper(d, rows.at[0], rows.at[1]);
  const auto cd_low = hn::InterleaveLower(d, rows.at[2], rows.at[3]);
  const auto cd_up = hn::InterleaveUpper(d, rows.at[2], rows.at[3]);
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(double)) {
    return {{hn::ConcatLowerLower(d, cd_low, ab_low), hn::ConcatLowerLower(d, cd_up, ab_up),
             hn::ConcatUpperUpper(d, cd_low, ab_low), hn::ConcatUpperUpper(d, cd_up, ab_up)}};
  } else {
    const hn::RepartitionToWide<hn::RebindToUnsigned<D>> wide;
    const auto low = [&](const auto& a, const auto& b) HWY_ATTR {
      return hn::BitCast(d, hn::InterleaveLower(wide, hn::BitCast(wide, a), hn::BitCast(wide, b)));
    };
    const auto up = [&](const auto& a, const auto& b) HWY_ATTR {
      return hn::BitCast(d, hn::InterleaveUpper(wide, hn::BitCast(wide, a), hn::BitCast(wide, b)));
    };
    return {{low(ab_low, cd_low), up(ab_low, cd_low), low(ab_up, cd_up), up(ab_up, cd_up)}};
  }
}

// Four structures at a time, or two where a register holds two numbers: their figures are read whole and transposed in
// registers.
template <class D, class S>
HWY_INLINE Columns<hn::Vec<D>> gather(D d, const S* of, const std::uint32_t* which, std::size_t offset) {
  using T = hn::TFromD<D>;
  const auto row = [&](auto part, std::size_t lane, std::size_t from) HWY_ATTR {
    return hn::LoadU(part, reinterpret_cast<const T*>(of + which[lane]) + offset + from);
  };
  if constexpr (hn::MaxLanes(D()) == 8) {
    const hn::FixedTag<T, 4> four;
    const auto low = gather(four, of, which, offset);
    const auto up = gather(four, of, which + 4, offset);
    return {{hn::Combine(d, up.at[0], low.at[0]), hn::Combine(d, up.at[1], low.at[1]),
             hn::Combine(d, up.at[2], low.at[2]), hn::Combine(d, up.at[3], low.at[3])}};
  } else if constexpr (hn::MaxLanes(D()) == 4) {
    return transposed(d, {{row(d, 0, 0), row(d, 1, 0), row(d, 2, 0), row(d, 3, 0)}});
  } else if constexpr (hn::MaxLanes(D()) == 2) {
    return {{hn::InterleaveLower(d, row(d, 0, 0), row(d, 1, 0)), hn::InterleaveUpper(d, row(d, 0, 0), row(d, 1, 0)),
             hn::InterleaveLower(d, row(d, 0, 2), row(d, 1, 2)), hn::InterleaveUpper(d, row(d, 0, 2), row(d, 1, 2))}};
  } else {
    return gather_singly(d, of, which, offset);
  }
}
template <class D, class S>
HWY_INLINE void scatter(D d, const Columns<hn::Vec<D>>& from, std::uint32_t dynamic, S* of, const std::uint32_t* which,
                        std::size_t offset) {
  using T = hn::TFromD<D>;
  const auto put = [&](auto part, const auto& value, std::size_t lane, std::size_t at)
                       HWY_ATTR { hn::StoreU(value, part, reinterpret_cast<T*>(of + which[lane]) + offset + at); };
  const auto yields = [&](std::size_t lane) { return (dynamic >> lane & 1U) != 0; };
  if constexpr (hn::MaxLanes(D()) == 8) {
    const hn::FixedTag<T, 4> four;
    using Four = Columns<hn::Vec<decltype(four)>>;
    scatter(four,
            Four{{hn::LowerHalf(four, from.at[0]), hn::LowerHalf(four, from.at[1]), hn::LowerHalf(four, from.at[2]),
                  hn::LowerHalf(four, from.at[3])}},
            dynamic, of, which, offset);
    scatter(four,
            Four{{hn::UpperHalf(four, from.at[0]), hn::UpperHalf(four, from.at[1]), hn::UpperHalf(four, from.at[2]),
                  hn::UpperHalf(four, from.at[3])}},
            dynamic >> 4U, of, which + 4, offset);
  } else if constexpr (hn::MaxLanes(D()) == 4) {
    const Columns<hn::Vec<D>> rows = transposed(d, from);
    for (std::size_t lane = 0; lane < 4; ++lane) {
      if (yields(lane)) put(d, rows.at[lane], lane, 0);
    }
  } else if constexpr (hn::MaxLanes(D()) == 2) {
    if (yields(0)) {
      put(d, hn::InterleaveLower(d, from.at[0], from.at[1]), 0, 0);
      put(d, hn::InterleaveLower(d, from.at[2], from.at[3]), 0, 2);
    }
    if (yields(1)) {
      put(d, hn::InterleaveUpper(d, from.at[0], from.at[1]), 1, 0);
      put(d, hn::InterleaveUpper(d, from.at[2], from.at[3]), 1, 2);
    }
  } else {
    scatter_singly(d, from, dynamic, of, which, offset);
  }
}
#endif

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
