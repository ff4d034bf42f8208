// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/manifold/manifold_clusters.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "collision/manifold/manifold_clusters.h"

#ifndef POISE_MANIFOLD_CLUSTERS_ONCE
#define POISE_MANIFOLD_CLUSTERS_ONCE
namespace poise::collision {

// |n - n'|^2 of two directions 45 degrees apart is 0.586.
inline constexpr float kInverseAngle = 1.0F / 0.586F;

void update_mean(ClusterState& state, std::size_t cluster);
void join_clusters(ClusterState& state, std::size_t first, std::size_t second);

}  // namespace poise::collision
#endif

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kLanes = NodeContacts::kLanes;

// Contacts with their weights, row by row.
struct WeightedContacts {
  alignas(32) float weight_m[kLanes];
  alignas(32) float normal_m[4 * kLanes];  // w n, w
  alignas(32) float point_m2[4 * kLanes];  // w p, 0
};

// A bit for each contact that weighs something.
HWY_INLINE std::uint32_t weigh(const NodeContacts& contacts, std::size_t count, float reach_m, WeightedContacts& into) {
  const hn::CappedTag<float, kLanes> d;
  alignas(32) static constexpr float kIndices[kLanes] = {0, 1, 2, 3, 4, 5, 6, 7};
  const auto zero = hn::Zero(d);
  std::uint32_t weighs = 0;
  for (std::size_t k = 0; k < kLanes; k += hn::Lanes(d)) {
    const auto used = hn::Lt(hn::Load(d, kIndices + k), hn::Set(d, static_cast<float>(count)));
    const auto weight =
        hn::IfThenElseZero(used, hn::Max(hn::Sub(hn::Set(d, reach_m), hn::Load(d, contacts.gap_m + k)), zero));
    hn::Store(weight, d, into.weight_m + k);
    const auto times = [&](const float* of) HWY_ATTR { return hn::Mul(weight, hn::Load(d, of + k)); };
    hn::StoreInterleaved4(times(contacts.normal[0]), times(contacts.normal[1]), times(contacts.normal[2]), weight, d,
                          into.normal_m + 4 * k);
    hn::StoreInterleaved4(times(contacts.point_m[0]), times(contacts.point_m[1]), times(contacts.point_m[2]), zero, d,
                          into.point_m2 + 4 * k);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Gt(weight, zero), bits);
    weighs |= std::uint32_t{bits[0]} << k;
  }
  return weighs;
}

// The nearest cluster of each contact, of those from `first` on, and a bit for each contact that is near enough to join
// it: at most size_m away, or at an angle of at most 45 degrees, or a part of each. Bits, because no processor foresees
// which are.
struct NearestClusters {
  alignas(32) float cluster[kLanes];
  std::uint32_t near;
};

HWY_INLINE void find_nearest(const NodeContacts& contacts, const ClusterState& state, std::size_t first,
                             NearestClusters& into) {
  const hn::CappedTag<float, kLanes> d;
  into.near = 0;
  for (std::size_t k = 0; k < kLanes; k += hn::Lanes(d)) {
    const auto at = [&](const float* of) HWY_ATTR { return hn::Load(d, of + k); };
    const auto px = at(contacts.point_m[0]);
    const auto py = at(contacts.point_m[1]);
    const auto pz = at(contacts.point_m[2]);
    const auto nx = at(contacts.normal[0]);
    const auto ny = at(contacts.normal[1]);
    const auto nz = at(contacts.normal[2]);
    auto least = hn::Set(d, std::numeric_limits<float>::max());
    auto nearest = hn::Zero(d);
    for (std::size_t c = first; c < state.count; ++c) {
      const auto square = [&](auto of, float mean) HWY_ATTR {
        const auto difference = hn::Sub(of, hn::Set(d, mean));
        return hn::Mul(difference, difference);
      };
      const auto place = hn::Add(hn::Add(square(px, state.center_m[0][c]), square(py, state.center_m[1][c])),
                                 square(pz, state.center_m[2][c]));
      const auto turn = hn::Add(hn::Add(square(nx, state.direction[0][c]), square(ny, state.direction[1][c])),
                                square(nz, state.direction[2][c]));
      const auto distance =
          hn::Add(hn::Mul(place, hn::Set(d, state.inverse_square)), hn::Mul(turn, hn::Set(d, kInverseAngle)));
      const auto nearer = hn::Lt(distance, least);
      least = hn::IfThenElse(nearer, distance, least);
      nearest = hn::IfThenElse(nearer, hn::Set(d, static_cast<float>(c)), nearest);
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Le(least, hn::Set(d, 1.0F)), bits);
    into.near |= std::uint32_t{bits[0]} << k;
    hn::Store(nearest, d, into.cluster + k);
  }
}

// Means of so many clusters at once.
constexpr std::size_t kMeans = 4;

// Means of the clusters whose weight is more than `growth` times the one at which they were made last. A cluster whose
// directions add up to none keeps its own.
#if HWY_TARGET == HWY_SCALAR
void update_means(float growth, ClusterState& state) {
  for (std::size_t c = 0; c < state.count; ++c) {
    if (state.sums[c].normal_m[3] > growth * state.mean_weight_m[c]) update_mean(state, c);
  }
}
#else
// Four rows of four numbers, by columns.
template <class V>
struct Columns {
  V x, y, z, w;
};
HWY_INLINE auto columns_of(const float* first, const float* second, const float* third, const float* fourth) {
  const hn::Full128<float> d;
  const auto a = hn::Load(d, first);
  const auto b = hn::Load(d, second);
  const auto c = hn::Load(d, third);
  const auto e = hn::Load(d, fourth);
  const auto xy01 = hn::InterleaveLower(d, a, b);
  const auto xy23 = hn::InterleaveLower(d, c, e);
  const auto zw01 = hn::InterleaveUpper(d, a, b);
  const auto zw23 = hn::InterleaveUpper(d, c, e);
  return Columns<hn::Vec<hn::Full128<float> > >{
      hn::ConcatLowerLower(d, xy23, xy01), hn::ConcatUpperUpper(d, xy23, xy01), hn::ConcatLowerLower(d, zw23, zw01),
      hn::ConcatUpperUpper(d, zw23, zw01)};
}

void update_means(float growth, ClusterState& state) {
  const hn::Full128<float> d;
  static_assert(kMeans == hn::MaxLanes(d));
  for (std::size_t c = 0; c < state.count; c += kMeans) {
    // Beyond the last one, that one again.
    const auto sums_of = [&](std::size_t k) -> const ClusterState::Sums& {
      return state.sums[std::min(c + k, state.count - std::size_t{1})];
    };
    const auto n = columns_of(sums_of(0).normal_m, sums_of(1).normal_m, sums_of(2).normal_m, sums_of(3).normal_m);
    const auto mean_weight = hn::LoadU(d, state.mean_weight_m.data() + c);
    const auto grown = hn::Gt(n.w, hn::Mul(hn::Set(d, growth), mean_weight));
    if (hn::AllFalse(d, grown)) continue;
    const auto p = columns_of(sums_of(0).point_m2, sums_of(1).point_m2, sums_of(2).point_m2, sums_of(3).point_m2);
    const auto length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(n.x, n.x), hn::Mul(n.y, n.y)), hn::Mul(n.z, n.z)));
    const auto turned = hn::And(grown, hn::Gt(length, hn::Zero(d)));
    const auto renew = [&](auto where, auto value, std::array<float, kLanes>& of) HWY_ATTR {
      hn::StoreU(hn::IfThenElse(where, value, hn::LoadU(d, of.data() + c)), d, of.data() + c);
    };
    renew(grown, n.w, state.mean_weight_m);
    renew(turned, hn::Div(n.x, length), state.direction[0]);
    renew(turned, hn::Div(n.y, length), state.direction[1]);
    renew(turned, hn::Div(n.z, length), state.direction[2]);
    renew(grown, hn::Div(p.x, n.w), state.center_m[0]);
    renew(grown, hn::Div(p.y, n.w), state.center_m[1]);
    renew(grown, hn::Div(p.z, n.w), state.center_m[2]);
  }
}
#endif

// The two clusters that are nearest to each other, the first such two in order.
void merge_nearest(ClusterState& state) {
  static_assert(ClusterState::kMost == kLanes);
  const hn::CappedTag<float, kLanes> d;
  alignas(32) static constexpr float kIndices[kLanes] = {0, 1, 2, 3, 4, 5, 6, 7};
  alignas(32) float leasts[kLanes];  // of each cluster, how far the nearest one before it is away
  alignas(32) float firsts[kLanes];  // and which that is
  for (std::size_t k = 0; k < kLanes; k += hn::Lanes(d)) {
    auto least = hn::Set(d, std::numeric_limits<float>::max());
    auto first = hn::Zero(d);
    const auto index = hn::Load(d, kIndices + k);
    const auto at = [&](const std::array<float, kLanes>& of) HWY_ATTR { return hn::LoadU(d, of.data() + k); };
    for (std::size_t i = 0; i + 1 < state.count; ++i) {
      const auto square = [&](const std::array<float, kLanes>& of) HWY_ATTR {
        const auto difference = hn::Sub(hn::Set(d, of[i]), at(of));
        return hn::Mul(difference, difference);
      };
      const auto place =
          hn::Add(hn::Add(square(state.center_m[0]), square(state.center_m[1])), square(state.center_m[2]));
      const auto turn =
          hn::Add(hn::Add(square(state.direction[0]), square(state.direction[1])), square(state.direction[2]));
      const auto distance =
          hn::Add(hn::Mul(place, hn::Set(d, state.inverse_square)), hn::Mul(turn, hn::Set(d, kInverseAngle)));
      const auto row = hn::Set(d, static_cast<float>(i));
      const auto nearer = hn::And(hn::Lt(distance, least), hn::Gt(index, row));
      least = hn::IfThenElse(nearer, distance, least);
      first = hn::IfThenElse(nearer, row, first);
    }
    hn::Store(least, d, leasts + k);
    hn::Store(first, d, firsts + k);
  }
  std::size_t second = 1;
  for (std::size_t j = 2; j < state.count; ++j) {
    if (leasts[j] < leasts[second] || (leasts[j] == leasts[second] && firsts[j] < firsts[second])) second = j;
  }
  join_clusters(state, static_cast<std::size_t>(firsts[second]), second);
}

// to += of, four floats.
HWY_INLINE void add_row(const float* of, float* to) {
  const hn::CappedTag<float, 4> d;
  for (std::size_t k = 0; k < 4; k += hn::Lanes(d))
    hn::Store(hn::Add(hn::Load(d, to + k), hn::Load(d, of + k)), d, to + k);
}

HWY_INLINE void join(const NodeContacts& contacts, const WeightedContacts& weighted, std::size_t lane,
                     ClusterState::Sums& sums) {
  add_row(weighted.normal_m + 4 * lane, sums.normal_m);
  add_row(weighted.point_m2 + 4 * lane, sums.point_m2);
  sums.gap_m = std::min(sums.gap_m, contacts.gap_m[lane]);
  sums.certain_separation_m = std::min(sums.certain_separation_m, contacts.certain_separation_m[lane]);
}

// Begins a cluster where there is room for one more.
void begin(const NodeContacts& contacts, const WeightedContacts& weighted, std::size_t lane, ClusterState& state) {
  const std::size_t cluster = state.count++;
  ClusterState::Sums& sums = state.sums[cluster];
  std::copy_n(weighted.normal_m + 4 * lane, 4, sums.normal_m);
  std::copy_n(weighted.point_m2 + 4 * lane, 4, sums.point_m2);
  sums.gap_m = contacts.gap_m[lane];
  sums.certain_separation_m = contacts.certain_separation_m[lane];
  state.mean_weight_m[cluster] = weighted.weight_m[lane];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state.direction[axis][cluster] = contacts.normal[axis][lane];
    state.center_m[axis][cluster] = contacts.point_m[axis][lane];
  }
}

void add(const NodeContacts& contacts, std::size_t count, ClusterState& state) {
  // Means are made again when the weight has grown by this factor. Chosen: piles settle as with means of every contact.
  constexpr float kGrowth = 1.25F;
  WeightedContacts weighted;
  std::uint32_t left = weigh(contacts, count, state.reach_m, weighted);
  if (left == 0) return;
  // Clusters from here on are new: no contact that is left is near any before them.
  std::size_t first = 0;
  while (left != 0) {
    NearestClusters nearest;
    find_nearest(contacts, state, first, nearest);
    for (std::uint32_t lanes = left & nearest.near; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      join(contacts, weighted, lane, state.sums[static_cast<std::size_t>(nearest.cluster[lane])]);
    }
    left &= ~nearest.near;
    if (left == 0) break;
    // None is near the first of the others.
    const bool full = state.count == ClusterState::kMost;
    if (full) merge_nearest(state);
    first = full ? 0 : state.count;
    begin(contacts, weighted, static_cast<std::size_t>(std::countr_zero(left)), state);
    left &= left - 1;
  }
  update_means(kGrowth, state);
}

// The points of all clusters, by their means.
void write(const ClusterState& state, ManifoldPoints& into) {
  const hn::CappedTag<double, kMeans> d;
  const hn::Rebind<float, decltype(d)> narrow;
  into.count = state.count;
  for (std::size_t c = 0; c < state.count; c += hn::Lanes(d)) {
    const auto wide = [&](const std::array<float, kLanes>& of)
                          HWY_ATTR { return hn::PromoteTo(d, hn::LoadU(narrow, of.data() + c)); };
    const auto x = wide(state.direction[0]);
    const auto y = wide(state.direction[1]);
    const auto z = wide(state.direction[2]);
    // The sum runs in the order of Eigen's norm.
    const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    const auto length = hn::IfThenElse(hn::Gt(square, hn::Zero(d)), hn::Sqrt(square), hn::Set(d, 1.0));
    alignas(64) double normal[3][kMeans];
    hn::Store(hn::Div(x, length), d, normal[0]);
    hn::Store(hn::Div(y, length), d, normal[1]);
    hn::Store(hn::Div(z, length), d, normal[2]);
    for (std::size_t k = 0; k < std::min<std::size_t>(hn::Lanes(d), state.count - c); ++k) {
      const auto center = [&](std::size_t axis) { return static_cast<double>(state.center_m[axis][c + k]); };
      const ClusterState::Sums& sums = state.sums[c + k];
      const double gap_m = static_cast<double>(sums.gap_m);
      ManifoldPoint& point = into.point[c + k];
      point.normal = {normal[0][k], normal[1][k], normal[2][k]};
      point.point_m = {center(0), center(1), center(2)};
      point.gap_m = gap_m;
      point.certain_separation_m = std::max(gap_m, static_cast<double>(sums.certain_separation_m));
    }
  }
}

void finish(ClusterState& state, ManifoldPoints& into) {
  update_means(0, state);
  write(state, into);
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {
HWY_EXPORT(add);
HWY_EXPORT(finish);

void update_mean(ClusterState& state, std::size_t cluster) {
  ClusterState::Sums& sums = state.sums[cluster];
  const float* const n = sums.normal_m;
  const float length = std::sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2]);
  state.mean_weight_m[cluster] = n[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (length > 0) state.direction[axis][cluster] = n[axis] / length;
    state.center_m[axis][cluster] = sums.point_m2[axis] / n[3];
  }
}

void join_clusters(ClusterState& state, std::size_t first, std::size_t second) {
  ClusterState::Sums& kept = state.sums[first];
  const ClusterState::Sums& gone = state.sums[second];
  for (std::size_t k = 0; k < 4; ++k) kept.normal_m[k] += gone.normal_m[k];
  for (std::size_t k = 0; k < 4; ++k) kept.point_m2[k] += gone.point_m2[k];
  kept.gap_m = std::min(kept.gap_m, gone.gap_m);
  kept.certain_separation_m = std::min(kept.certain_separation_m, gone.certain_separation_m);
  update_mean(state, first);
  for (std::size_t c = second; c + 1 < state.count; ++c) {
    state.sums[c] = state.sums[c + 1];
    state.mean_weight_m[c] = state.mean_weight_m[c + 1];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.direction[axis][c] = state.direction[axis][c + 1];
      state.center_m[axis][c] = state.center_m[axis][c + 1];
    }
  }
  --state.count;
}

void ManifoldClusters::add(const NodeContacts& contacts, std::size_t count) {
  HWY_DYNAMIC_DISPATCH(add)(contacts, count, state_);
}

void ManifoldClusters::write(ManifoldPoints& into) { HWY_DYNAMIC_DISPATCH(finish)(state_, into); }

}  // namespace poise::collision
#endif
