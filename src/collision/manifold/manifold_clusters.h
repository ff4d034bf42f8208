// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

#include "collision/manifold/manifold_point.h"
#include "poise/types.h"

namespace poise::collision {

/// One contact of two nodes, in the frame of a.
struct NodeContact {
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b
  Vec3 point_m = Vec3::Zero();  ///< in the middle between the two surfaces
  double gap_m = 0;
  double certain_separation_m = 0;  ///< below zero the objects certainly penetrate
};

/// Clusters the contacts of a front into few contact points: each contact joins the nearest cluster in position and
/// direction, or starts a new one while there is capacity, else it joins the nearest. Weights are w = reach - gap. The
/// result depends on the order of contacts, which is that of the front.
class ManifoldClusters {
 public:
  /// Contacts count when their gap is below `reach_m`; those within `size_m` of a cluster may join it.
  ManifoldClusters(double reach_m, double size_m) : reach_m_(reach_m), inverse_square_(1.0 / (size_m * size_m)) {}
  void add(const NodeContact& contact);
  /// Writes the manifold: at most kMaxManifoldPoints; the nearest clusters are merged until they fit.
  void finish(ManifoldPoints& into);

 private:
  static constexpr std::size_t kRoom = 2 * kMaxManifoldPoints;
  struct Cluster {
    Vec3 normal_m = Vec3::Zero();  ///< sum of w n
    Vec3 place_m2 = Vec3::Zero();  ///< sum of w p
    double weight_m = 0;
    Vec3 direction, point_m;                     ///< means, up to date
    double gap_m = 0, certain_separation_m = 0;  ///< least
    void update();
  };
  /// Squared distance of a contact and a cluster: 1 at a distance of size_m, or at an angle of 45 degrees.
  [[nodiscard]] double apart(const Vec3& point_m, const Vec3& normal, const Cluster& cluster) const;
  void merge_nearest();

  double reach_m_, inverse_square_;
  std::size_t count_ = 0;
  std::array<Cluster, kRoom> clusters_;
};

}  // namespace poise::collision
