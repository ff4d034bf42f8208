// SPDX-License-Identifier: MIT
// The figures of several bodies read into lanes. Read once for each
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

#include "geometry/primitives/triple_lanes_inl.h"
#include "solver/contacts/contact_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using geometry::HWY_NAMESPACE::cross;
using geometry::HWY_NAMESPACE::difference;
using geometry::HWY_NAMESPACE::dot;
using geometry::HWY_NAMESPACE::scaled;
using geometry::HWY_NAMESPACE::sum;
using geometry::HWY_NAMESPACE::Triple;

template <class D, class T, std::size_t kWidth>
HWY_INLINE Triple<hn::Vec<D>> load(D d, const T (*from)[kWidth], std::size_t lane) {
  return {hn::Load(d, from[0] + lane), hn::Load(d, from[1] + lane), hn::Load(d, from[2] + lane)};
}
template <class D, class V, class T>
HWY_INLINE void store(D d, const Triple<V>& value, T (*to)[kLanes], std::size_t lane) {
  hn::Store(value.x, d, to[0] + lane);
  hn::Store(value.y, d, to[1] + lane);
  hn::Store(value.z, d, to[2] + lane);
}
// A matrix in each lane.
template <class V>
struct Turn {
  Triple<V> column[3];
};
// In the order of Eigen's products of a matrix and a vector, whose bits these are.
template <class V>
HWY_INLINE Triple<V> turned(const Turn<V>& by, const Triple<V>& v) {
  const Triple<V> x = scaled(v.x, by.column[0]);
  const Triple<V> y = scaled(v.y, by.column[1]);
  const Triple<V> z = scaled(v.z, by.column[2]);
  return {hn::Add(hn::Add(x.x, y.x), z.x), hn::Add(hn::Add(x.y, y.y), z.y), hn::Add(x.z, hn::Add(y.z, z.z))};
}

// Four figures of as many bodies as there are lanes.
template <class V>
struct Columns {
  V at[4];
};

// Where four figures of a structure begin that stands `at` an index, from the `offset`-th number on.
template <class T, class S>
HWY_INLINE T* figures_at(S* of, std::size_t at, std::size_t offset) {
  return reinterpret_cast<T*>(of + at) + offset;
}

// Four figures from `at` on, in the only lane.
template <class D, class T>
HWY_INLINE Columns<hn::Vec<D>> one_column(D d, const T* at) {
  return {{hn::LoadU(d, at), hn::LoadU(d, at + 1), hn::LoadU(d, at + 2), hn::LoadU(d, at + 3)}};
}
// The way back.
template <class D, class T>
HWY_INLINE void store_one_row(D d, const Columns<hn::Vec<D>>& from, T* at) {
  for (std::size_t k = 0; k < 4; ++k) hn::StoreU(from.at[k], d, at + k);
}

#if HWY_TARGET == HWY_SCALAR
// Four figures from row(lane) on, for each lane.
template <class D, class Row>
HWY_INLINE Columns<hn::Vec<D>> columns_of(D d, const Row& row) {
  return one_column(d, row(0));
}
// The way back, for the lanes of `which`.
template <class D, class Row>
HWY_INLINE void store_rows(D d, const Columns<hn::Vec<D>>& from, std::uint32_t which, const Row& row) {
  if ((which & 1U) != 0) store_one_row(d, from, row(0));
}
#else
// Four rows of four numbers to four columns, or back.
template <class D>
HWY_INLINE Columns<hn::Vec<D>> transposed(D d, const Columns<hn::Vec<D>>& rows) {
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(float)) {
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
  } else {
    const auto ab_even = hn::InterleaveLower(d, rows.at[0], rows.at[1]);
    const auto ab_odd = hn::InterleaveUpper(d, rows.at[0], rows.at[1]);
    const auto cd_even = hn::InterleaveLower(d, rows.at[2], rows.at[3]);
    const auto cd_odd = hn::InterleaveUpper(d, rows.at[2], rows.at[3]);
    return {{hn::ConcatLowerLower(d, cd_even, ab_even), hn::ConcatLowerLower(d, cd_odd, ab_odd),
             hn::ConcatUpperUpper(d, cd_even, ab_even), hn::ConcatUpperUpper(d, cd_odd, ab_odd)}};
  }
}

// Four figures from row(lane) on, for each lane: read whole and transposed in registers.
template <class D, class Row>
HWY_INLINE Columns<hn::Vec<D>> columns_of(D d, const Row& row) {
  using T = hn::TFromD<D>;
  if constexpr (hn::MaxLanes(D()) == 1) {
    return one_column(d, row(0));
  } else if constexpr (hn::MaxLanes(D()) == 2) {
    const auto quads = [&](std::size_t k) HWY_ATTR { return hn::LoadU(d, row(0) + k); };
    const auto others = [&](std::size_t k) HWY_ATTR { return hn::LoadU(d, row(1) + k); };
    return {{hn::InterleaveLower(d, quads(0), others(0)), hn::InterleaveUpper(d, quads(0), others(0)),
             hn::InterleaveLower(d, quads(2), others(2)), hn::InterleaveUpper(d, quads(2), others(2))}};
  } else {
    const hn::FixedTag<T, 4> four;
    const auto quad = [&](std::size_t lane) HWY_ATTR { return hn::LoadU(four, row(lane)); };
    const auto first = transposed(four, {{quad(0), quad(1), quad(2), quad(3)}});
    if constexpr (hn::MaxLanes(D()) == 8) {
      const auto second = transposed(four, {{quad(4), quad(5), quad(6), quad(7)}});
      return {{hn::Combine(d, second.at[0], first.at[0]), hn::Combine(d, second.at[1], first.at[1]),
               hn::Combine(d, second.at[2], first.at[2]), hn::Combine(d, second.at[3], first.at[3])}};
    } else {
      return first;
    }
  }
}
// The way back, for the lanes of `which`.
template <class D, class Row>
HWY_INLINE void store_rows(D d, const Columns<hn::Vec<D>>& from, std::uint32_t which, const Row& row) {
  using T = hn::TFromD<D>;
  if constexpr (hn::MaxLanes(D()) == 1) {
    if ((which & 1U) != 0) store_one_row(d, from, row(0));
  } else if constexpr (hn::MaxLanes(D()) == 2) {
    const auto pair = [&](std::size_t lane, const auto& first, const auto& second) HWY_ATTR {
      if ((which >> lane & 1U) == 0) return;
      hn::StoreU(first, d, row(lane));
      hn::StoreU(second, d, row(lane) + 2);
    };
    pair(0, hn::InterleaveLower(d, from.at[0], from.at[1]), hn::InterleaveLower(d, from.at[2], from.at[3]));
    pair(1, hn::InterleaveUpper(d, from.at[0], from.at[1]), hn::InterleaveUpper(d, from.at[2], from.at[3]));
  } else {
    const hn::FixedTag<T, 4> four;
    using Four = Columns<hn::Vec<decltype(four)>>;
    const auto quad = [&](const Four& columns, std::size_t lane) HWY_ATTR {
      const Four rows = transposed(four, columns);
      for (std::size_t k = 0; k < 4; ++k) {
        if ((which >> (lane + k) & 1U) != 0) hn::StoreU(rows.at[k], four, row(lane + k));
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
  }
}
#endif

// The figures from `offset` on of the structures of `bodies`, which begin with numbers of type T, one after another.
template <class D, class S>
HWY_INLINE Columns<hn::Vec<D>> gather(D d, const S* of, const std::uint32_t* bodies, std::size_t offset) {
  return columns_of(d, [&](std::size_t lane) { return figures_at<const hn::TFromD<D>>(of, bodies[lane], offset); });
}
// The way back, for the bodies that yield.
template <class D, class S>
HWY_INLINE void scatter(D d, const Columns<hn::Vec<D>>& from, std::uint32_t dynamic, S* of, const std::uint32_t* bodies,
                        std::size_t offset) {
  store_rows(d, from, dynamic, [&](std::size_t lane) { return figures_at<hn::TFromD<D>>(of, bodies[lane], offset); });
}

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
