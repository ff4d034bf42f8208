// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "world/renew_points.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <cstdint>
#include <limits>

#include "solver/lane_math_inl.h"
#include "world/renew_points.h"

HWY_BEFORE_NAMESPACE();
namespace poise::simulation::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace lanes = solver::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 4>;
using V = hn::Vec<Doubles>;
using Three = lanes::Triple<V>;

// As many points as fill whole registers.
constexpr std::size_t kRows = (kPointsOfPair + 3) / 4 * 4;

HWY_INLINE Three all(Doubles d, const double* of) { return {hn::Set(d, of[0]), hn::Set(d, of[1]), hn::Set(d, of[2])}; }

template <class S>
HWY_INLINE lanes::Columns<V> quads(Doubles d, const S* const* of, std::size_t offset) {
  return lanes::columns_of(d, [&](std::size_t k) { return lanes::figures_at<const double>(of[k], 0, offset); });
}

constexpr std::size_t kLanes = hn::MaxLanes(Doubles());
constexpr std::size_t kParts = kForcesOfPair / kLanes;

// The old points of a manifold, one a lane.
struct OldPoints {
  std::size_t parts;  // that hold points
  Three normal[kParts], on_a_m[kParts];
  V barrier[kParts];  // of those that are taken larger than any square of a distance, else 0
};
HWY_INLINE void read(Doubles d, const solver::ContactPoint* points, std::size_t count, OldPoints& into) {
  const solver::ContactPoint* rows[kForcesOfPair];
  for (std::size_t k = 0; k < kForcesOfPair; ++k) rows[k] = points + (k < count ? k : 0);
  into.parts = (count + kLanes - 1) / kLanes;
  for (std::size_t part = 0; part < into.parts; ++part) {
    const lanes::Columns<V> first = quads(d, rows + part * kLanes, 0);
    const lanes::Columns<V> second = quads(d, rows + part * kLanes, 4);
    into.normal[part] = {first.at[0], first.at[1], first.at[2]};
    into.on_a_m[part] = {second.at[0], second.at[1], second.at[2]};
    const auto absent = hn::Ge(hn::Iota(d, static_cast<double>(part * kLanes)), hn::Set(d, static_cast<double>(count)));
    into.barrier[part] = hn::IfThenElseZero(absent, hn::Set(d, std::numeric_limits<double>::max()));
  }
}

// The old point that is nearest to a new one, if it is within the distance, faces alike and is not taken; it is then.
// kForcesOfPair if there is none.
HWY_INLINE std::size_t take_nearest(Doubles d, const solver::ContactPoint& point, double square_m2, OldPoints& old) {
  constexpr double kLike = 0.7;
  const Three normal = all(d, point.normal.data());
  const Three on_a = all(d, point.on_a_m.data());
  const V most = hn::Set(d, std::numeric_limits<double>::max());
  V squares[kParts];
  V least = most;
  for (std::size_t part = 0; part < old.parts; ++part) {
    const Three away = lanes::difference(old.on_a_m[part], on_a);
    const auto alike = hn::Ge(lanes::dot(old.normal[part], normal), hn::Set(d, kLike));
    squares[part] = hn::IfThenElse(alike, hn::Max(lanes::dot(away, away), old.barrier[part]), most);
    least = hn::Min(least, squares[part]);
  }
  least = hn::MinOfLanes(d, least);
  if (!(hn::GetLane(least) < square_m2)) return kForcesOfPair;
  std::size_t nearest = 0;
  for (std::size_t part = 0; part < old.parts; ++part) {
    const std::intptr_t lane = hn::FindFirstTrue(d, hn::Eq(squares[part], least));
    if (lane < 0) continue;
    nearest = part * kLanes + static_cast<std::size_t>(lane);
    break;
  }
  for (std::size_t part = 0; part < old.parts; ++part) {
    const auto here = hn::Eq(hn::Iota(d, static_cast<double>(part * kLanes)), hn::Set(d, static_cast<double>(nearest)));
    old.barrier[part] = hn::IfThenElse(here, most, old.barrier[part]);
  }
  return nearest;
}

// A force, as four numbers.
HWY_INLINE void copy_force(Doubles d, const double* from, double* to) {
  for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) hn::Store(hn::Load(d, from + k), d, to + k);
}
HWY_INLINE double* numbers(solver::ContactForce& force) { return lanes::figures_at<double>(&force, 0, 0); }
HWY_INLINE const double* numbers(const solver::ContactForce& force) {
  return lanes::figures_at<const double>(&force, 0, 0);
}

// Fixes all points to the bodies.
HWY_INLINE void place(Doubles d, const PlacedPair& pair, const RenewedPoints& renewed,
                      std::array<double, kPointsOfPair>& gaps_m) {
  const collision::ManifoldPoint* rows[kRows];
  for (std::size_t k = 0; k < kRows; ++k) rows[k] = renewed.found[0];
  for (std::size_t k = 1; k < renewed.count; ++k) rows[k] = renewed.found[k];
  const double* const a = pair.a.rotation.data();
  const double* const b = pair.b.rotation.data();
  const lanes::Turn<V> to_world = {{all(d, a), all(d, a + 3), all(d, a + 6)}};
  const auto row = [&](std::size_t k) HWY_ATTR {
    return Three{hn::Set(d, b[k]), hn::Set(d, b[k + 3]), hn::Set(d, b[k + 6])};
  };
  const lanes::Turn<V> to_b = {{row(0), row(1), row(2)}};
  const V half = hn::Set(d, 0.5);
  alignas(32) double gaps[kRows];
  for (std::size_t lane = 0; lane < renewed.count; lane += hn::Lanes(d)) {
    const lanes::Columns<V> first = quads(d, rows + lane, 0);
    const lanes::Columns<V> second = quads(d, rows + lane, 4);
    const Three found_normal = {first.at[0], first.at[1], first.at[2]};
    const Three middle = {first.at[3], second.at[0], second.at[1]};
    const V found_gap = second.at[2];
    const Three normal = lanes::turned(to_world, found_normal);
    const Three on_a = lanes::difference(middle, lanes::scaled(hn::Mul(half, found_gap), found_normal));
    const Three place_a = lanes::sum(all(d, pair.a.position_m.data()), lanes::turned(to_world, on_a));
    V gap = found_gap;
    // The normal of the pair points into the plane.
    if (pair.plane) gap = hn::Sub(hn::Neg(lanes::dot(normal, place_a)), hn::Set(d, pair.height_m));
    hn::Store(gap, d, gaps + lane);
    const Three normal_b = lanes::turned(to_b, normal);
    const Three from_b = lanes::difference(place_a, all(d, pair.b.position_m.data()));
    const V plane_b = hn::Add(lanes::dot(normal, from_b), gap);
    const std::size_t left = renewed.count - lane;
    const std::uint32_t present = (1U << (left < hn::Lanes(d) ? left : hn::Lanes(d))) - 1U;
    const auto to = [&](std::size_t offset) {
      return [&renewed, lane, offset](std::size_t k) {
        return lanes::figures_at<double>(renewed.points, lane + k, offset);
      };
    };
    lanes::store_rows(d, lanes::Columns<V>{{normal_b.x, normal_b.y, normal_b.z, plane_b}}, present, to(0));
    lanes::store_rows(d, lanes::Columns<V>{{on_a.x, on_a.y, on_a.z, hn::Sub(second.at[3], found_gap)}}, present, to(4));
  }
  for (std::size_t k = 0; k < renewed.count; ++k) gaps_m[k] = gaps[k];
}

void renew(const PlacedPair& pair, const RenewedPoints& renewed, std::array<double, kPointsOfPair>& gaps_m) {
  static_assert(sizeof(solver::ContactPoint) == 8 * sizeof(double) &&
                sizeof(collision::ManifoldPoint) == 8 * sizeof(double));
  const Doubles d;
  const std::size_t before = PointCache::before_manifold(renewed.count);
  const std::size_t count = PointCache::manifold_count(renewed.count);
  solver::ContactForce* const forces = renewed.forces + before;
  if (renewed.old_count == 0) {
    place(d, pair, renewed, gaps_m);
    for (std::size_t i = 0; i < count; ++i) forces[i] = {};
    return;
  }
  const std::size_t old_count = PointCache::manifold_count(renewed.old_count);
  OldPoints old;
  const std::size_t old_before = PointCache::before_manifold(renewed.old_count);
  read(d, renewed.old_points + old_before, old_count, old);
  // The last is for points that are new.
  alignas(32) double old_forces[kForcesOfPair + 1][4];
  for (std::size_t k = 0; k < old_count; ++k) copy_force(d, numbers(renewed.old_forces[old_before + k]), old_forces[k]);
  for (double& none : old_forces[kForcesOfPair]) none = 0;
  place(d, pair, renewed, gaps_m);
  const double square_m2 = renewed.alike_m * renewed.alike_m;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t nearest = take_nearest(d, renewed.points[before + i], square_m2, old);
    copy_force(d, old_forces[nearest], numbers(forces[i]));
  }
}

}  // namespace poise::simulation::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::simulation {

HWY_EXPORT(renew);

void renew_points(const PlacedPair& pair, const RenewedPoints& renewed, std::array<double, kPointsOfPair>& gaps_m) {
  HWY_DYNAMIC_DISPATCH(renew)(pair, renewed, gaps_m);
}

}  // namespace poise::simulation
#endif
