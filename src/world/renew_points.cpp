// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "world/renew_points.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

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
constexpr std::size_t kRows = 8;
static_assert(kPointsOfPair <= kRows);

HWY_INLINE Three all(Doubles d, const double* of) { return {hn::Set(d, of[0]), hn::Set(d, of[1]), hn::Set(d, of[2])}; }

template <class S>
HWY_INLINE lanes::Columns<V> quads(Doubles d, const S* const* of, std::size_t offset) {
  return lanes::columns_of(d, [&](std::size_t k) { return lanes::figures_at<const double>(of[k], 0, offset); });
}

// The old points of a manifold, one a lane.
struct OldPoints {
  alignas(32) double normal[3][kForcesOfPair];
  alignas(32) double on_a_m[3][kForcesOfPair];
};
HWY_INLINE void read(Doubles d, const solver::ContactPoint* points, std::size_t count, OldPoints& into) {
  const solver::ContactPoint* rows[kForcesOfPair];
  for (std::size_t k = 0; k < kForcesOfPair; ++k) rows[k] = points + (k < count ? k : 0);
  for (std::size_t lane = 0; lane < count; lane += hn::Lanes(d)) {
    const lanes::Columns<V> first = quads(d, rows + lane, 0);
    const lanes::Columns<V> second = quads(d, rows + lane, 4);
    for (std::size_t k = 0; k < 3; ++k) {
      hn::Store(first.at[k], d, into.normal[k] + lane);
      hn::Store(second.at[k], d, into.on_a_m[k] + lane);
    }
  }
}

// Squares of the distances of the old points from a new one; of those that face elsewhere what is larger than any.
HWY_INLINE void measure(Doubles d, const OldPoints& old, std::size_t count, const solver::ContactPoint& point,
                        double (&squares)[kForcesOfPair]) {
  constexpr double kLike = 0.7;
  const Three normal = all(d, point.normal.data());
  const Three on_a = all(d, point.on_a_m.data());
  const V most = hn::Set(d, std::numeric_limits<double>::max());
  for (std::size_t lane = 0; lane < count; lane += hn::Lanes(d)) {
    const Three away = lanes::difference(lanes::load(d, old.on_a_m, lane), on_a);
    const auto alike = hn::Ge(lanes::dot(lanes::load(d, old.normal, lane), normal), hn::Set(d, kLike));
    hn::Store(hn::IfThenElse(alike, lanes::dot(away, away), most), d, squares + lane);
  }
}

// Fixes all points to the bodies.
HWY_INLINE void place(Doubles d, const PlacedPair& pair, const RenewedPoints& renewed,
                      std::array<double, kPointsOfPair>& gaps_m) {
  const collision::ManifoldPoint* rows[kRows];
  for (std::size_t k = 0; k < kRows; ++k) rows[k] = renewed.found[k < renewed.count ? k : 0];
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
  solver::ContactForce* const forces = renewed.forces;
  if (renewed.old_count == 0) {
    place(d, pair, renewed, gaps_m);
    for (std::size_t i = 0; i < count; ++i) forces[i] = {};
    return;
  }
  const std::size_t old_count = PointCache::manifold_count(renewed.old_count);
  OldPoints old;
  read(d, renewed.points + PointCache::before_manifold(renewed.old_count), old_count, old);
  // The last is for points that are new.
  std::array<solver::ContactForce, kForcesOfPair + 1> old_forces;
  for (std::size_t k = 0; k < old_count; ++k) old_forces[k] = forces[k];
  place(d, pair, renewed, gaps_m);
  std::uint32_t taken = 0;
  for (std::size_t i = 0; i < count; ++i) {
    alignas(32) double squares[kForcesOfPair];
    measure(d, old, old_count, renewed.points[before + i], squares);
    double least = renewed.alike_m * renewed.alike_m;
    std::size_t nearest = kForcesOfPair;
    for (std::size_t k = 0; k < old_count; ++k) {
      const bool nearer = squares[k] < least && (taken >> k & 1U) == 0;
      least = nearer ? squares[k] : least;
      nearest = nearer ? k : nearest;
    }
    taken |= 1U << nearest;
    forces[i] = old_forces[nearest];
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
