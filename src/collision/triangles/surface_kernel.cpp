// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/triangles/surface_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "collision/triangles/surface_kernel.h"
#include "collision/triangles/triangle_pair.h"
#include "geometry/primitives/triple_lanes_inl.h"

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, 16>;
using FourLanes = hn::CappedTag<float, 4>;
constexpr Lanes kLanes;

using geometry::HWY_NAMESPACE::Triple;

template <class V>
HWY_INLINE V length(const Triple<V>& u) {
  return hn::Sqrt(dot(u, u));
}
template <class V>
HWY_INLINE V least(V a, V b, V c) {
  return hn::Min(hn::Min(a, b), c);
}
template <class V>
HWY_INLINE V most(V a, V b, V c) {
  return hn::Max(hn::Max(a, b), c);
}
template <class D, class Mask>
HWY_INLINE std::uint32_t bits_of(D d, Mask mask) {
  std::uint8_t stored[8] = {};
  hn::StoreMaskBits(d, mask, stored);
  return std::uint32_t{stored[0]} | std::uint32_t{stored[1]} << 8U;
}

template <class D, class V>
HWY_INLINE Triple<V> turned(D d, const SurfaceFrame& frame, const Triple<V>& u) {
  const auto row = [&](std::size_t i) HWY_ATTR {
    return dot({hn::Set(d, frame.rotation[i][0]), hn::Set(d, frame.rotation[i][1]), hn::Set(d, frame.rotation[i][2])},
               u);
  };
  return {row(0), row(1), row(2)};
}
template <class D, class V>
HWY_INLINE Triple<V> placed(D d, const SurfaceFrame& frame, const Triple<V>& u) {
  const Triple<V> there = turned(d, frame, u);
  return {hn::Add(there.x, hn::Set(d, frame.offset_m[0])), hn::Add(there.y, hn::Set(d, frame.offset_m[1])),
          hn::Add(there.z, hn::Set(d, frame.offset_m[2]))};
}

// Which box of a node stands in which lane.
template <class D>
struct OneBox {  // the first in all
  HWY_INLINE hn::Vec<D> operator()(D d, const float* four, std::size_t /*first*/) const { return hn::Set(d, four[0]); }
};
template <class D>
struct EachBox {  // each in turn
  HWY_INLINE hn::Vec<D> operator()(D d, const float* four, std::size_t first) const {
#if HWY_TARGET == HWY_SCALAR
    return hn::Set(d, four[first % 4]);
#else
    static_cast<void>(first);
    return hn::LoadDup128(d, four);
#endif
  }
};
template <class D>
struct EachBoxFourTimes {
  HWY_INLINE hn::Vec<D> operator()(D d, const float* four, std::size_t first) const {
#if HWY_TARGET == HWY_SCALAR
    return hn::Set(d, four[first / 4]);
#else
    alignas(64) static constexpr std::int32_t kBox[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
    return hn::TableLookupLanes(hn::LoadDup128(d, four), hn::SetTableIndices(d, kBox + first));
#endif
  }
};

// Boxes as `pick_a` and `pick_b` put them into lanes; squares in the order of the lanes, a bit for each that is within.
template <class D, class PickA, class PickB>
HWY_INLINE std::uint32_t compare_boxes(D d, std::size_t pairs, const SurfaceFrame& frame, const FourBoxes& a,
                                       PickA pick_a, const FourBoxes& b, PickB pick_b, float limit_m2,
                                       float* squared_m2) {
  using V = hn::Vec<D>;
  using Points = Triple<V>;
  const V half = hn::Set(d, 0.5F);
  const V zero = hn::Zero(d);
  std::uint32_t within = 0;
  for (std::size_t first = 0; first < pairs; first += hn::Lanes(d)) {
    const auto boxes = [&](const FourBoxes& from, auto pick, Points& center, Points& extent) HWY_ATTR {
      const auto axis = [&](std::size_t i, V& middle, V& wide) HWY_ATTR {
        const V low = pick(d, from.low_m + 4 * i, first);
        const V high = pick(d, from.high_m + 4 * i, first);
        middle = hn::Mul(half, hn::Add(low, high));
        wide = hn::Mul(half, hn::Sub(high, low));
      };
      axis(0, center.x, extent.x);
      axis(1, center.y, extent.y);
      axis(2, center.z, extent.z);
    };
    Points center_a;
    Points half_a;
    Points center_b;
    Points half_b;
    boxes(a, pick_a, center_a, half_a);
    boxes(b, pick_b, center_b, half_b);
    // The distance of two boxes along a frame's axes: of one box and of the box around the other in that frame.
    const auto outside = [&](const Points& between, const Points& own, const Points& other) HWY_ATTR {
      const auto axis = [&](V apart, V u, V v)
                            HWY_ATTR { return hn::Max(hn::Sub(hn::Sub(hn::Abs(apart), u), v), zero); };
      const Points apart = {axis(between.x, own.x, other.x), axis(between.y, own.y, other.y),
                            axis(between.z, own.z, other.z)};
      return dot(apart, apart);
    };
    const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
    const auto row = [&](std::size_t i) HWY_ATTR {
      return dot({set(frame.absolute[i][0]), set(frame.absolute[i][1]), set(frame.absolute[i][2])}, half_b);
    };
    const auto column = [&](const auto& matrix, std::size_t j, const Points& u) HWY_ATTR {
      return dot({set(matrix[0][j]), set(matrix[1][j]), set(matrix[2][j])}, u);
    };
    const Points between = difference(center_a, placed(d, frame, center_b));
    const V along_a = outside(between, half_a, {row(0), row(1), row(2)});
    const Points across = {column(frame.rotation, 0, between), column(frame.rotation, 1, between),
                           column(frame.rotation, 2, between)};
    const V along_b = outside(
        across, half_b,
        {column(frame.absolute, 0, half_a), column(frame.absolute, 1, half_a), column(frame.absolute, 2, half_a)});
    const V squared = hn::Max(along_a, along_b);
    hn::StoreU(squared, d, squared_m2 + first);
    within |= bits_of(d, hn::Le(squared, set(limit_m2))) << first;
  }
  return within;
}

std::uint32_t compare_nodes(const SurfaceFrame& frame, const FourBoxes& a, const FourBoxes& b, float limit_m2,
                            std::array<float, kBoxPairs>& squared_m2) {
  // A node that stays whole has one box: four lanes do, which a processor with two units for them has sooner.
  constexpr FourLanes kFour;
  if (a.single) {
    return compare_boxes(kFour, 4, frame, a, OneBox<FourLanes>{}, b, EachBox<FourLanes>{}, limit_m2, squared_m2.data());
  }
  if (!b.single) {
    return compare_boxes(kLanes, kBoxPairs, frame, a, EachBoxFourTimes<Lanes>{}, b, EachBox<Lanes>{}, limit_m2,
                         squared_m2.data());
  }
  float squared[4];
  const std::uint32_t found =
      compare_boxes(kFour, 4, frame, a, EachBox<FourLanes>{}, b, OneBox<FourLanes>{}, limit_m2, squared);
  std::uint32_t within = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    squared_m2[4 * i] = squared[i];
    within |= (found >> i & 1U) << 4 * i;
  }
  return within;
}

using V = hn::Vec<Lanes>;
using Points = Triple<V>;
using M = hn::Mask<Lanes>;

struct Triangles {
  Points corner[3];
  Points normal;
  V features, spread_rad;
};

HWY_INLINE Triangles load(const NearRows& rows, std::size_t first) {
  Triangles t;
  hn::LoadInterleaved4(kLanes, rows.row[0][first].data(), t.corner[0].x, t.corner[0].y, t.corner[0].z, t.normal.x);
  hn::LoadInterleaved4(kLanes, rows.row[1][first].data(), t.corner[1].x, t.corner[1].y, t.corner[1].z, t.normal.y);
  hn::LoadInterleaved4(kLanes, rows.row[2][first].data(), t.corner[2].x, t.corner[2].y, t.corner[2].z, t.normal.z);
  V unused[2];
  hn::LoadInterleaved4(kLanes, rows.row[3][first].data(), t.features, t.spread_rad, unused[0], unused[1]);
  return t;
}

// How far the heights of a triangle's corners are all on one side.
HWY_INLINE V one_sided(const V (&heights)[3]) {
  return hn::Max(least(heights[0], heights[1], heights[2]),
                 hn::Sub(hn::Zero(kLanes), most(heights[0], heights[1], heights[2])));
}

// How deep corners lie beneath a plane, where that is no more than `beneath`.
HWY_INLINE V deepest(const V (&heights)[3], bool solid, V beneath) {
  V deepest = hn::Zero(kLanes);
  for (const V& height : heights) {
    const V depth = solid ? hn::Sub(hn::Zero(kLanes), height) : hn::Abs(height);
    deepest = hn::Max(deepest, hn::IfThenElseZero(hn::Le(depth, beneath), depth));
  }
  return deepest;
}

// Of the sides of a face: how far the other triangle lies beyond one of them, less what rounding allows and less the
// reach, and how well each of its corners lies over the face. An error of a corner moves a product with a side's normal
// by as much as the other point is away, and by the length of the side.
struct OffSides {
  V at_all, beyond_reach;
};
HWY_INLINE OffSides compare_sides(const Triangles& face, const Triangles& other, V reach, V past_rim, V rounding,
                                  V (&over)[3]) {
  Points along[3];
  V lengths[3];
  for (std::size_t k = 0; k < 3; ++k) {
    along[k] = difference(face.corner[(k + 1) % 3], face.corner[k]);
    lengths[k] = length(along[k]);
  }
  const V wide = hn::Add(length(difference(other.corner[1], other.corner[0])),
                         length(difference(other.corner[2], other.corner[0])));
  const V extent = hn::Add(hn::Add(length(difference(other.corner[0], face.corner[0])), wide),
                           most(lengths[0], lengths[1], lengths[2]));
  OffSides off;
  for (std::size_t k = 0; k < 3; ++k) {
    const Points into = cross(face.normal, along[k]);
    const V slack = hn::Mul(rounding, hn::Add(extent, lengths[k]));
    V inside[3];
    for (std::size_t m = 0; m < 3; ++m) {
      inside[m] = dot(into, difference(other.corner[m], face.corner[k]));
      const V there = hn::Add(hn::Add(inside[m], hn::Mul(past_rim, lengths[k])), slack);
      over[m] = k == 0 ? there : hn::Min(over[m], there);
    }
    const V beyond = hn::Sub(hn::Sub(hn::Zero(kLanes), most(inside[0], inside[1], inside[2])), slack);
    const V beyond_reach = hn::Sub(beyond, hn::Mul(hn::Add(reach, past_rim), lengths[k]));
    off.at_all = k == 0 ? beyond : hn::Max(off.at_all, beyond);
    off.beyond_reach = k == 0 ? beyond_reach : hn::Max(off.beyond_reach, beyond_reach);
  }
  return off;
}

// Which features of a triangle come within reach of the other's plane: a corner over the other's face, and any at all.
HWY_INLINE void near_features(const Triangles& t, const V (&heights)[3], const V (&over)[3], V reach, M& on_face,
                              M& any) {
  const hn::RebindToSigned<Lanes> whole;
  const auto bits = hn::ConvertTo(whole, t.features);
  const auto owns = [&](std::uint8_t first, std::size_t k) HWY_ATTR {
    return hn::RebindMask(kLanes, hn::TestBit(bits, hn::Set(whole, std::int32_t{first} << k)));
  };
  const V opposite = hn::Sub(hn::Zero(kLanes), reach);
  for (std::size_t k = 0; k < 3; ++k) {
    const V here = heights[k];
    const V next = heights[(k + 1) % 3];
    const M corner = hn::And(owns(ShapeSurface::kVertex0, k), hn::Le(hn::Abs(here), reach));
    const M side = hn::And(owns(ShapeSurface::kEdge0, k),
                           hn::And(hn::Le(hn::Min(here, next), reach), hn::Ge(hn::Max(here, next), opposite)));
    const M over_it = hn::And(corner, hn::Ge(over[k], hn::Zero(kLanes)));
    on_face = k == 0 ? over_it : hn::Or(on_face, over_it);
    any = k == 0 ? hn::Or(corner, side) : hn::Or(any, hn::Or(corner, side));
  }
}

TriangleAnswers compare(const SurfaceFrame& frame, const TriangleTest& test, const NearRows& rows_a,
                        const NearRows& rows_b) {
  // Rounding of the product of two unit vectors.
  constexpr float kCosineRounding = 1e-5F;
  const V zero = hn::Zero(kLanes);
  const V rounding = hn::Set(kLanes, test.rounding_m);
  const V reach = hn::Set(kLanes, std::max(test.apart_m, test.beneath_m) + test.rounding_m);
  const V beneath = hn::Set(kLanes, test.beneath_m + test.rounding_m);
  TriangleAnswers answers{0, 0, 0};
  for (std::size_t first = 0; first < NearRows::kPairs; first += hn::Lanes(kLanes)) {
    const Triangles a = load(rows_a, first);
    Triangles b = load(rows_b, first);
    b.normal = turned(kLanes, frame, b.normal);
    for (Points& corner : b.corner) corner = placed(kLanes, frame, corner);
    V a_above_b[3];
    V b_above_a[3];
    for (std::size_t k = 0; k < 3; ++k) {
      a_above_b[k] = dot(b.normal, difference(a.corner[k], b.corner[0]));
      b_above_a[k] = dot(a.normal, difference(b.corner[k], a.corner[0]));
    }
    const V off_planes = hn::Max(one_sided(a_above_b), one_sided(b_above_a));
    // Features beneath a face may lie past its rim.
    const V past_rim =
        hn::Mul(hn::Set(kLanes, static_cast<float>(kPastRim)),
                hn::Max(deepest(a_above_b, test.solid_b, beneath), deepest(b_above_a, test.solid_a, beneath)));
    V a_over_b[3];
    V b_over_a[3];
    const OffSides off_a = compare_sides(a, b, reach, past_rim, rounding, b_over_a);
    const OffSides off_b = compare_sides(b, a, reach, past_rim, rounding, a_over_b);
    M a_on_face;
    M b_on_face;
    M any_of_a;
    M any_of_b;
    near_features(a, a_above_b, a_over_b, reach, a_on_face, any_of_a);
    near_features(b, b_above_a, b_over_a, reach, b_on_face, any_of_b);
    // Sides and corners face each other along a direction in the cones of normals of both.
    const V angle = hn::Add(hn::Add(a.spread_rad, b.spread_rad), hn::Set(kLanes, static_cast<float>(kLeanOfBoth)));
    const V cones = hn::Sub(hn::Mul(hn::Mul(hn::Set(kLanes, 0.5F), angle), angle),
                            hn::Add(dot(a.normal, b.normal), hn::Set(kLanes, 1 - kCosineRounding)));
    const M facing = hn::And(hn::And(any_of_a, any_of_b), hn::Ge(cones, zero));
    const M near = hn::And(hn::Le(off_planes, reach), hn::Le(hn::Max(off_a.beyond_reach, off_b.beyond_reach), zero));
    const M crossing = hn::And(hn::Le(off_planes, rounding), hn::Le(hn::Max(off_a.at_all, off_b.at_all), zero));
    const M owning = hn::Gt(hn::Max(a.features, b.features), zero);
    answers.near |= bits_of(kLanes, hn::And(near, owning)) << first;
    answers.may_cross |= bits_of(kLanes, crossing) << first;
    answers.may_face |= bits_of(kLanes, hn::And(near, hn::Or(hn::Or(a_on_face, b_on_face), facing))) << first;
  }
  return answers;
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {

HWY_EXPORT(compare_nodes);
HWY_EXPORT(compare);

std::uint32_t boxes_within(const SurfaceFrame& frame, const FourBoxes& a, const FourBoxes& b, float limit_m2,
                           std::array<float, kBoxPairs>& squared_m2) {
  return HWY_DYNAMIC_DISPATCH(compare_nodes)(frame, a, b, limit_m2, squared_m2);
}

void NearRows::set(std::size_t pair, const ShapeSurface::NearTriangle& triangle) {
  static_assert(sizeof(ShapeSurface::NearTriangle) == 4 * sizeof(row[0][0]));
  std::array<std::array<float, 4>, 4> rows;
  std::memcpy(rows.data(), &triangle, sizeof(rows));
  for (std::size_t k = 0; k < 4; ++k) row[k][pair] = rows[k];
}

TriangleAnswers compare_triangles(const SurfaceFrame& frame, const TriangleTest& test, const NearRows& a,
                                  const NearRows& b) {
  return HWY_DYNAMIC_DISPATCH(compare)(frame, test, a, b);
}

}  // namespace poise::collision
#endif
