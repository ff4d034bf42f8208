// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/manifold/fitted_sums.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <array>

#include "collision/manifold/fitted_sums.h"

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kLanes = NodeContacts::kLanes;
// Exponents beyond these say no more. Many entries are merely near, and all together must weigh nothing; eighth powers
// stay within single precision, and out of the numbers near 0 that are slow.
constexpr float kLargest = 6, kSmallest = -16;
constexpr float kLeastPointWeight = 4.54e-5F;  ///< of the weights, exp(-10)
constexpr float kBeyond = 1e30F;

// Fits of one side, a lane each.
template <class V>
struct Fits {
  V x, y, z, radius, core;
};

// As many entries as there are lanes.
using Block = std::span<const FrontEntry, kLanes>;

template <NodeIndex FrontEntry::*kSide>
HWY_INLINE const float* row_of(const NodeFit* fits, Block entries, std::size_t k) {
  static_assert(sizeof(NodeFit) == 6 * sizeof(float));
  return &fits[entries[k].*kSide].x_m;
}

// Calls use(block, count) for entries eight at a time, in order. In the last block the last entry stands for those that
// are not there.
template <class Use>
HWY_INLINE void for_each_block(std::span<const FrontEntry> entries, Use&& use) {
  for (; entries.size() >= kLanes; entries = entries.subspan(kLanes)) use(entries.first<kLanes>(), kLanes);
  if (entries.empty()) return;
  std::array<FrontEntry, kLanes> last;
  for (std::size_t k = 0; k < kLanes; ++k) last[k] = entries[std::min(k, entries.size() - 1)];
  use(Block(last), entries.size());
}

#if HWY_TARGET == HWY_SCALAR
template <NodeIndex FrontEntry::*kSide, class D>
HWY_INLINE auto fits_of(D d, const NodeFit* fits, Block entries, std::size_t k) {
  const float* const row = row_of<kSide>(fits, entries, k);
  const auto at = [&](std::size_t i) { return hn::Set(d, row[i]); };
  return Fits<hn::Vec<D>>{at(0), at(1), at(2), at(3), at(5)};
}
#else
// Four rows, loaded whole and transposed in registers: a vector that is read where single figures have just been
// written has to wait for them.
template <NodeIndex FrontEntry::*kSide>
HWY_INLINE auto four_fits(const NodeFit* fits, Block entries, std::size_t first) {
  const hn::Full128<float> d;
  const float* const rows[] = {row_of<kSide>(fits, entries, first), row_of<kSide>(fits, entries, first + 1),
                               row_of<kSide>(fits, entries, first + 2), row_of<kSide>(fits, entries, first + 3)};
  const auto low = [&](std::size_t i)
                       HWY_ATTR { return hn::InterleaveLower(d, hn::LoadU(d, rows[i]), hn::LoadU(d, rows[i + 1])); };
  const auto high = [&](std::size_t i, std::size_t from) HWY_ATTR {
    return hn::InterleaveUpper(d, hn::LoadU(d, rows[i] + from), hn::LoadU(d, rows[i + 1] + from));
  };
  const auto xy01 = low(0);
  const auto xy23 = low(2);
  const auto zr01 = high(0, 0);
  const auto zr23 = high(2, 0);
  return Fits<hn::Vec<hn::Full128<float>>>{hn::ConcatLowerLower(d, xy23, xy01), hn::ConcatUpperUpper(d, xy23, xy01),
                                           hn::ConcatLowerLower(d, zr23, zr01), hn::ConcatUpperUpper(d, zr23, zr01),
                                           hn::ConcatUpperUpper(d, high(2, 2), high(0, 2))};
}

template <NodeIndex FrontEntry::*kSide, class D>
HWY_INLINE auto fits_of(D d, const NodeFit* fits, Block entries, std::size_t k) {
  const auto low = four_fits<kSide>(fits, entries, k);
  if constexpr (hn::MaxLanes(D()) == 4) {
    return low;
  } else {
    const auto high = four_fits<kSide>(fits, entries, k + 4);
    return Fits<hn::Vec<D>>{hn::Combine(d, high.x, low.x), hn::Combine(d, high.y, low.y), hn::Combine(d, high.z, low.z),
                            hn::Combine(d, high.radius, low.radius), hn::Combine(d, high.core, low.core)};
  }
}
#endif

// What the lanes have gathered.
struct Lanes {
  alignas(32) float direction[3][kLanes] = {}, place[3][kLanes] = {}, weight[kLanes] = {}, gap[kLanes], cores[kLanes];
};

// exp(t) to a thousandth for |t| <= 6 and to a half down to -16, of operations that round alike everywhere: a
// polynomial to the sixteenth power.
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

// Contacts of some lanes: where the fitted spheres of a are, the way to those of b, and how far it is.
template <class V>
struct LaneContacts {
  V ax, ay, az, dx, dy, dz, distance, radius_a, radius_b, core;
};

// For a plane, a sphere of b of radius 0 stands under each of a's on the plane.
template <class D>
HWY_INLINE auto contacts_of(D d, const PairFrame& frame, Block entries, std::size_t k) {
  const auto set = [&](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
  LaneContacts<hn::Vec<D>> c;
  const auto a = fits_of<&FrontEntry::a>(d, frame.a->tree.fit.data(), entries, k);
  c.ax = a.x;
  c.ay = a.y;
  c.az = a.z;
  c.radius_a = a.radius;
  c.core = a.core;
  if (frame.with_plane()) {
    const auto nx = set(frame.plane_normal.x());
    const auto ny = set(frame.plane_normal.y());
    const auto nz = set(frame.plane_normal.z());
    const auto height =
        hn::Sub(hn::Add(hn::Add(hn::Mul(nx, c.ax), hn::Mul(ny, c.ay)), hn::Mul(nz, c.az)), set(frame.plane_height_m));
    c.dx = hn::Neg(hn::Mul(height, nx));
    c.dy = hn::Neg(hn::Mul(height, ny));
    c.dz = hn::Neg(hn::Mul(height, nz));
    c.radius_b = hn::Zero(d);
  } else {
    const auto b = fits_of<&FrontEntry::b>(d, frame.b->tree.fit.data(), entries, k);
    const auto row = [&](std::size_t r) HWY_ATTR {
      const float* const turn = frame.rounded.rotation + 3 * r;
      return hn::Add(hn::Add(hn::Mul(hn::Set(d, turn[0]), b.x), hn::Mul(hn::Set(d, turn[1]), b.y)),
                     hn::Add(hn::Mul(hn::Set(d, turn[2]), b.z), hn::Set(d, frame.rounded.offset_m[r])));
    };
    c.dx = hn::Sub(row(0), c.ax);
    c.dy = hn::Sub(row(1), c.ay);
    c.dz = hn::Sub(row(2), c.az);
    c.radius_b = b.radius;
    c.core = hn::Add(c.core, b.core);
  }
  const auto square = hn::Add(hn::Add(hn::Mul(c.dx, c.dx), hn::Mul(c.dy, c.dy)), hn::Mul(c.dz, c.dz));
  c.distance = hn::Sqrt(square);
  // A centre beneath the plane is at a negative distance from it, and the direction stays that of the plane.
  if (frame.with_plane()) {
    const auto along =
        hn::Add(hn::Add(hn::Mul(c.dx, set(frame.plane_normal.x())), hn::Mul(c.dy, set(frame.plane_normal.y()))),
                hn::Mul(c.dz, set(frame.plane_normal.z())));
    c.distance = hn::CopySign(c.distance, hn::Neg(along));
  }
  return c;
}

// What weights are made of.
struct Weighing {
  float expected_gap_m, inverse_width;
};

// Adds the first `count` contacts of a block to the lanes.
HWY_INLINE void add_block(const PairFrame& frame, const Weighing& weighing, Block entries, std::size_t count,
                          Lanes& sums) {
  const hn::CappedTag<float, kLanes> d;
  alignas(32) static constexpr float kIndices[kLanes] = {0, 1, 2, 3, 4, 5, 6, 7};
  for (std::size_t k = 0; k < kLanes; k += hn::Lanes(d)) {
    const auto used = hn::Lt(hn::Load(d, kIndices + k), hn::Set(d, static_cast<float>(count)));
    const auto c = contacts_of(d, frame, entries, k);
    const auto ax = c.ax;
    const auto ay = c.ay;
    const auto az = c.az;
    const auto dx = c.dx;
    const auto dy = c.dy;
    const auto dz = c.dz;
    const auto distance = c.distance;
    const auto radius_a = c.radius_a;
    const auto radius_b = c.radius_b;
    const auto core = c.core;
    const auto gap = hn::Sub(distance, hn::Add(radius_a, radius_b));
    const auto steepness =
        hn::Mul(hn::Sub(hn::Set(d, weighing.expected_gap_m), gap), hn::Set(d, weighing.inverse_width));
    const auto exponent = hn::Min(hn::Max(steepness, hn::Set(d, kSmallest)), hn::Set(d, kLargest));
    const auto weight = hn::IfThenElseZero(used, exponential(d, exponent));
    auto sharp = hn::IfThenElseZero(used, hn::Max(weight, hn::Set(d, kLeastPointWeight)));
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
    const auto far = hn::Set(d, kBeyond);
    const auto lower = [&](float* to, auto value) HWY_ATTR {
      hn::Store(hn::Min(hn::Load(d, to + k), hn::IfThenElse(used, value, far)), d, to + k);
    };
    lower(sums.gap, gap);
    lower(sums.cores, hn::Sub(distance, core));
  }
}

void contacts(const PairFrame& frame, Block entries, NodeContacts& into) {
  const hn::CappedTag<float, kLanes> d;
  // Centres that coincide have no direction of their own.
  Vec3 direction = frame.offset_m.isZero(0) ? Vec3(Vec3::UnitZ()) : Vec3(frame.offset_m.normalized());
  if (frame.with_plane()) direction = -frame.plane_normal;
  for (std::size_t k = 0; k < kLanes; k += hn::Lanes(d)) {
    const auto c = contacts_of(d, frame, entries, k);
    const auto apart = hn::Ne(c.distance, hn::Zero(d));
    const auto inverse = hn::IfThenElseZero(apart, hn::Div(hn::Set(d, 1.0F), c.distance));
    const auto half = hn::Mul(hn::Set(d, 0.5F), hn::Mul(inverse, hn::Add(c.distance, hn::Sub(c.radius_a, c.radius_b))));
    const auto own = hn::Ne(frame.with_plane() ? hn::Zero(d) : c.distance, hn::Zero(d));
    const auto normal = [&](Eigen::Index axis, auto along) HWY_ATTR {
      return hn::IfThenElse(own, hn::Mul(inverse, along), hn::Set(d, static_cast<float>(direction[axis])));
    };
    hn::Store(hn::Sub(c.distance, hn::Add(c.radius_a, c.radius_b)), d, into.gap_m + k);
    hn::Store(hn::Sub(c.distance, c.core), d, into.certain_separation_m + k);
    hn::Store(normal(0, c.dx), d, into.normal[0] + k);
    hn::Store(normal(1, c.dy), d, into.normal[1] + k);
    hn::Store(normal(2, c.dz), d, into.normal[2] + k);
    hn::Store(hn::Add(c.ax, hn::Mul(half, c.dx)), d, into.point_m[0] + k);
    hn::Store(hn::Add(c.ay, hn::Mul(half, c.dy)), d, into.point_m[1] + k);
    hn::Store(hn::Add(c.az, hn::Mul(half, c.dz)), d, into.point_m[2] + k);
  }
}

void add(const PairFrame& frame, std::span<const FrontEntry> entries, FittedSums& sums) {
  const Weighing weighing{static_cast<float>(frame.expected_gap_m), static_cast<float>(1.0 / frame.width_m)};
  Lanes lanes;
  std::fill_n(lanes.gap, kLanes, kBeyond);
  std::fill_n(lanes.cores, kLanes, kBeyond);
  for_each_block(entries,
                 [&](Block block, std::size_t count) HWY_ATTR { add_block(frame, weighing, block, count, lanes); });
  const auto sum = [](const float(&of)[kLanes]) {
    return static_cast<double>(((of[0] + of[4]) + (of[2] + of[6])) + ((of[1] + of[5]) + (of[3] + of[7])));
  };
  const auto least = [](const float(&of)[kLanes]) { return static_cast<double>(*std::min_element(of, of + kLanes)); };
  // Number by number: a vector that is read where single numbers have just been written waits for them.
  const auto add_to = [&](const float(&of)[3][kLanes], Vec3& into) {
    for (std::size_t axis = 0; axis < 3; ++axis) into[static_cast<Eigen::Index>(axis)] += sum(of[axis]);
  };
  add_to(lanes.direction, sums.direction);
  add_to(lanes.place, sums.point_m);
  sums.weight += sum(lanes.weight);
  sums.fitted_m = std::min(sums.fitted_m, least(lanes.gap));
  sums.cores_m = std::min(sums.cores_m, least(lanes.cores));
}

void least_gaps(const PairFrame& frame, std::span<const FrontEntry> entries, FittedSums& sums) {
  const hn::CappedTag<float, kLanes> d;
  auto gaps = hn::Set(d, kBeyond);
  auto cores = gaps;
  for_each_block(entries, [&](Block block, std::size_t) HWY_ATTR {
    for (std::size_t k = 0; k < kLanes; k += hn::Lanes(d)) {
      const auto c = contacts_of(d, frame, block, k);
      gaps = hn::Min(gaps, hn::Sub(c.distance, hn::Add(c.radius_a, c.radius_b)));
      cores = hn::Min(cores, hn::Sub(c.distance, c.core));
    }
  });
  sums.fitted_m = std::min(sums.fitted_m, static_cast<double>(hn::GetLane(hn::MinOfLanes(d, gaps))));
  sums.cores_m = std::min(sums.cores_m, static_cast<double>(hn::GetLane(hn::MinOfLanes(d, cores))));
  sums.weight += static_cast<double>(entries.size());
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {

HWY_EXPORT(add);
HWY_EXPORT(contacts);
HWY_EXPORT(least_gaps);

void add_fitted(const PairFrame& frame, std::span<const FrontEntry> entries, FittedSums& sums) {
  if (!entries.empty()) HWY_DYNAMIC_DISPATCH(add)(frame, entries, sums);
}

void add_least_gaps(const PairFrame& frame, std::span<const FrontEntry> entries, FittedSums& sums) {
  if (!entries.empty()) HWY_DYNAMIC_DISPATCH(least_gaps)(frame, entries, sums);
}

void fitted_contacts(const PairFrame& frame, std::span<const FrontEntry, NodeContacts::kLanes> entries,
                     NodeContacts& into) {
  HWY_DYNAMIC_DISPATCH(contacts)(frame, entries, into);
}

}  // namespace poise::collision
#endif
