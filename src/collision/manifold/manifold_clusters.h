// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "collision/manifold/manifold_point.h"
#include "poise/types.h"

namespace poise::collision {

/// Up to eight contacts of two nodes each, a figure an array; the frame of a.
struct NodeContacts {
  static constexpr std::size_t kLanes = 8;
  alignas(32) float gap_m[kLanes]{};
  alignas(32) float certain_separation_m[kLanes]{};  ///< below zero the objects certainly penetrate
  alignas(32) float normal[3][kLanes]{};             ///< unit, from a to b
  alignas(32) float point_m[3][kLanes]{};            ///< in the middle between the two surfaces
};

/// Clusters in progress, plain data for the kernels.
struct ClusterState {
  static constexpr std::size_t kMost = kMaxManifoldPoints;
  /// Rows of four floats, added at once.
  struct Sums {
    alignas(16) float normal_m[4];      ///< sum of w n, and of w
    alignas(16) float point_m2[4];      ///< sum of w p, and 0
    float gap_m, certain_separation_m;  ///< least
  };
  float reach_m, inverse_square;
  std::uint32_t count = 0;
  std::array<Sums, kMost> sums;
  std::array<float, kMost> direction[3], center_m[3];  ///< means
  std::array<float, kMost> mean_weight_m;              ///< at which the means were made; of a cluster to come, most
};

/// Clusters the contacts of a front into few contact points: each contact joins the nearest cluster in position and
/// direction, or starts a new one; the nearest two are merged where there are too many. Weights are w = reach - gap.
/// The result depends on the order of contacts, which is that of the front, and on nothing else: the same bits on any
/// instruction set.
class ManifoldClusters {
 public:
  /// Contacts count when their gap is below `reach_m`; those within `size_m` of a cluster may join it.
  ManifoldClusters(double reach_m, double size_m) {
    state_.reach_m = static_cast<float>(reach_m);
    state_.inverse_square = static_cast<float>(1.0 / (size_m * size_m));
    state_.mean_weight_m.fill(std::numeric_limits<float>::max());
  }
  /// Adds the first `count` contacts, 1 to 8.
  void add(const NodeContacts& contacts, std::size_t count);
  /// The manifold: a point for each cluster.
  void write(ManifoldPoints& into);

 private:
  ClusterState state_;
};

}  // namespace poise::collision
