// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/fitted_sums.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>

#include "collision/fitted_sums.h"

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kLanes = 8;
// Exponents beyond these say no more. Many entries are merely near, and all together must weigh nothing; eighth powers stay within single
// precision, and out of the numbers near 0 that are slow.
constexpr float kLargest = 6, kSmallest = -16;
constexpr float kLeastOfPlaces = 4.54e-5F;  ///< of the weights, exp(-10)
constexpr float kBeyond = 1e30F;

// Fits of one side, a figure an array.
struct Fits {
  alignas(32) float x[kLanes], y[kLanes], z[kLanes], radius[kLanes], core[kLanes];
};

template <NodeIndex FrontEntry::*kSide>
HWY_INLINE void gather(const NodeFit* fits, std::span<const FrontEntry> entries, Fits& into) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    const NodeFit& fit = fits[entries[std::min(k, entries.size() - 1)].*kSide];
    into.x[k] = fit.x_m;
    into.y[k] = fit.y_m;
    into.z[k] = fit.z_m;
    into.radius[k] = fit.radius_m;
    into.core[k] = fit.core_m;
  }
}

// What the lanes have gathered.
struct Lanes {
  alignas(32) float direction[3][kLanes] = {}, place[3][kLanes] = {}, weight[kLanes] = {}, gap[kLanes], cores[kLanes];
  alignas(32) float rest_direction[3][kLanes] = {}, rest_moment[3][kLanes] = {}, rest_weight[kLanes] = {};
};

// exp(t) to a thousandth for |t| <= 6 and to a half down to -16, of operations that round alike everywhere: a polynomial to the
// sixteenth power.
template <class D, class V>
HWY_INLINE V exponential(D d, V t) {
  const V x = hn::Mul(t, hn::Set(d, 1.0F / 16));
  V sum = hn::Add(hn::Mul(x, hn::Set(d, 1.0F / 24)), hn::Set(d, 1.0F / 6));
  sum = hn::Add(hn::Mul(x, sum), hn::Set(d, 0.5F));
  sum = hn::Add(hn::Mul(x, sum), hn::Set(d, 1.0F));
  sum = hn::Add(hn::Mul(x, sum), hn::Set(d, 1.0F));
  for (int i = 0; i < 4; ++i) sum = hn::Mul(sum, sum);
  return sum;
}

// Adds up to eight contacts to the lanes. For a plane, a sphere of b of radius 0 stands under each of a's on the plane.
void add_block(const PairFrame& frame, std::span<const FrontEntry> entries, Lanes& sums) {
  const hn::CappedTag<float, kLanes> d;
  alignas(32) static constexpr float kPlaces[kLanes] = {0, 1, 2, 3, 4, 5, 6, 7};
  const bool plane = frame.with_plane();
  Fits a;
  Fits b;
  gather<&FrontEntry::a>(frame.a->tree.fit.data(), entries, a);
  if (!plane) gather<&FrontEntry::b>(frame.b->tree.fit.data(), entries, b);
  const auto set = [&](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
  for (std::size_t k = 0; k < kLanes; k += hn::Lanes(d)) {
    const auto at = [&](const float* from) HWY_ATTR { return hn::Load(d, from + k); };
    const auto used = hn::Lt(at(kPlaces), hn::Set(d, static_cast<float>(entries.size())));
    const auto ax = at(a.x);
    const auto ay = at(a.y);
    const auto az = at(a.z);
    auto dx = hn::Zero(d);
    auto dy = hn::Zero(d);
    auto dz = hn::Zero(d);
    auto radius_b = hn::Zero(d);
    auto core = at(a.core);
    if (plane) {
      const auto nx = set(frame.plane_normal.x());
      const auto ny = set(frame.plane_normal.y());
      const auto nz = set(frame.plane_normal.z());
      const auto height = hn::Sub(hn::Add(hn::Add(hn::Mul(nx, ax), hn::Mul(ny, ay)), hn::Mul(nz, az)), set(frame.plane_height_m));
      dx = hn::Neg(hn::Mul(height, nx));
      dy = hn::Neg(hn::Mul(height, ny));
      dz = hn::Neg(hn::Mul(height, nz));
    } else {
      const auto bx = at(b.x);
      const auto by = at(b.y);
      const auto bz = at(b.z);
      const auto row = [&](int r) HWY_ATTR {
        const float* const turn = frame.rounded.rotation + 3 * r;
        return hn::Add(hn::Add(hn::Mul(hn::Set(d, turn[0]), bx), hn::Mul(hn::Set(d, turn[1]), by)),
                       hn::Add(hn::Mul(hn::Set(d, turn[2]), bz), hn::Set(d, frame.rounded.offset_m[r])));
      };
      dx = hn::Sub(row(0), ax);
      dy = hn::Sub(row(1), ay);
      dz = hn::Sub(row(2), az);
      radius_b = at(b.radius);
      core = hn::Add(core, at(b.core));
    }
    const auto square = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
    auto distance = hn::Sqrt(square);
    // A centre beneath the plane is at a negative distance from it, and the direction stays that of the plane.
    if (plane) {
      const auto along = hn::Add(hn::Add(hn::Mul(dx, set(frame.plane_normal.x())), hn::Mul(dy, set(frame.plane_normal.y()))),
                                 hn::Mul(dz, set(frame.plane_normal.z())));
      distance = hn::CopySign(distance, hn::Neg(along));
    }
    const auto radius_a = at(a.radius);
    const auto gap = hn::Sub(distance, hn::Add(radius_a, radius_b));
    const auto steepness = hn::Mul(hn::Sub(set(frame.expected_gap_m), gap), set(1.0 / frame.breadth_m));
    const auto exponent = hn::Min(hn::Max(steepness, hn::Set(d, kSmallest)), hn::Set(d, kLargest));
    const auto weight = hn::IfThenElseZero(used, exponential(d, exponent));
    auto sharp = hn::IfThenElseZero(used, hn::Max(weight, hn::Set(d, kLeastOfPlaces)));
    sharp = hn::Mul(sharp, sharp);
    sharp = hn::Mul(sharp, sharp);
    sharp = hn::Mul(sharp, sharp);
    const auto apart = hn::Ne(distance, hn::Zero(d));
    const auto inverse = hn::IfThenElseZero(apart, hn::Div(hn::Set(d, 1.0F), distance));
    const auto half = hn::Mul(hn::Set(d, 0.5F), hn::Mul(inverse, hn::Add(distance, hn::Sub(radius_a, radius_b))));
    const auto broad = hn::Mul(weight, inverse);
    const auto add = [&](float* to, auto value) HWY_ATTR { hn::Store(hn::Add(hn::Load(d, to + k), value), d, to + k); };
    add(sums.direction[0], hn::Mul(broad, dx));
    add(sums.direction[1], hn::Mul(broad, dy));
    add(sums.direction[2], hn::Mul(broad, dz));
    const auto px = hn::Add(ax, hn::Mul(half, dx));
    const auto py = hn::Add(ay, hn::Mul(half, dy));
    const auto pz = hn::Add(az, hn::Mul(half, dz));
    add(sums.place[0], hn::Mul(sharp, px));
    add(sums.place[1], hn::Mul(sharp, py));
    add(sums.place[2], hn::Mul(sharp, pz));
    add(sums.weight, sharp);
    const auto overlap = hn::IfThenElseZero(used, hn::Max(hn::Sub(set(frame.skin_m), gap), hn::Zero(d)));
    const auto flat = hn::Mul(overlap, inverse);
    const auto lx = hn::Mul(flat, dx);
    const auto ly = hn::Mul(flat, dy);
    const auto lz = hn::Mul(flat, dz);
    add(sums.rest_direction[0], lx);
    add(sums.rest_direction[1], ly);
    add(sums.rest_direction[2], lz);
    add(sums.rest_moment[0], hn::Sub(hn::Mul(py, lz), hn::Mul(pz, ly)));
    add(sums.rest_moment[1], hn::Sub(hn::Mul(pz, lx), hn::Mul(px, lz)));
    add(sums.rest_moment[2], hn::Sub(hn::Mul(px, ly), hn::Mul(py, lx)));
    add(sums.rest_weight, overlap);
    const auto far = hn::Set(d, kBeyond);
    const auto lower = [&](float* to, auto value)
                           HWY_ATTR { hn::Store(hn::Min(hn::Load(d, to + k), hn::IfThenElse(used, value, far)), d, to + k); };
    lower(sums.gap, gap);
    lower(sums.cores, hn::Sub(distance, core));
  }
}

void add(const PairFrame& frame, std::span<const FrontEntry> entries, FittedSums& sums) {
  Lanes lanes;
  std::fill_n(lanes.gap, kLanes, kBeyond);
  std::fill_n(lanes.cores, kLanes, kBeyond);
  for (std::size_t begin = 0; begin < entries.size(); begin += kLanes) {
    add_block(frame, entries.subspan(begin, std::min(kLanes, entries.size() - begin)), lanes);
  }
  const auto sum = [](const float(&of)[kLanes]) {
    return static_cast<double>(((of[0] + of[4]) + (of[2] + of[6])) + ((of[1] + of[5]) + (of[3] + of[7])));
  };
  const auto least = [](const float(&of)[kLanes]) { return static_cast<double>(*std::min_element(of, of + kLanes)); };
  const auto sum3 = [&](const float(&of)[3][kLanes]) { return Vec3(sum(of[0]), sum(of[1]), sum(of[2])); };
  sums.direction += sum3(lanes.direction);
  sums.place_m += sum3(lanes.place);
  sums.rest_direction_m += sum3(lanes.rest_direction);
  sums.rest_moment_m2 += sum3(lanes.rest_moment);
  sums.rest_weight_m += sum(lanes.rest_weight);
  sums.weight += sum(lanes.weight);
  sums.fitted_m = std::min(sums.fitted_m, least(lanes.gap));
  sums.cores_m = std::min(sums.cores_m, least(lanes.cores));
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {

HWY_EXPORT(add);

void add_fitted(const PairFrame& frame, std::span<const FrontEntry> entries, FittedSums& sums) {
  if (!entries.empty()) HWY_DYNAMIC_DISPATCH(add)(frame, entries, sums);
}

}  // namespace poise::collision
#endif
