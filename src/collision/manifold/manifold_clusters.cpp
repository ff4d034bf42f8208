// SPDX-License-Identifier: MIT
#include "collision/manifold/manifold_clusters.h"

#include <algorithm>
#include <limits>

namespace poise::collision {
namespace {

// |n - n'|^2 of two directions 45 degrees apart is 0.586.
constexpr double kInverseAngle = 1.0 / 0.586;

}  // namespace

void ManifoldClusters::Cluster::update() {
  const double length = normal_m.norm();
  if (length > 0) direction = normal_m / length;
  point_m = place_m2 / weight_m;
}

double ManifoldClusters::apart(const Vec3& point_m, const Vec3& normal, const Cluster& cluster) const {
  return (point_m - cluster.point_m).squaredNorm() * inverse_square_ +
         (normal - cluster.direction).squaredNorm() * kInverseAngle;
}

void ManifoldClusters::add(const NodeContact& contact) {
  const double weight = reach_m_ - contact.gap_m;
  if (!(weight > 0)) return;
  Cluster* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count_; ++i) {
    const double distance = apart(contact.point_m, contact.normal, clusters_[i]);
    if (distance >= least) continue;
    least = distance;
    nearest = &clusters_[i];
  }
  if (nearest == nullptr || least > 1.0) {
    if (count_ == kRoom) {
      merge_nearest();
    }
    nearest = &clusters_[count_++];
    *nearest = {weight * contact.normal, weight * contact.point_m,    weight, contact.normal, contact.point_m,
                contact.gap_m,           contact.certain_separation_m};
    return;
  }
  nearest->normal_m += weight * contact.normal;
  nearest->place_m2 += weight * contact.point_m;
  nearest->weight_m += weight;
  nearest->gap_m = std::min(nearest->gap_m, contact.gap_m);
  nearest->certain_separation_m = std::min(nearest->certain_separation_m, contact.certain_separation_m);
  nearest->update();
}

void ManifoldClusters::merge_nearest() {
  std::size_t first = 0;
  std::size_t second = 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count_; ++i) {
    for (std::size_t j = i + 1; j < count_; ++j) {
      const double distance = apart(clusters_[j].point_m, clusters_[j].direction, clusters_[i]);
      if (distance >= least) continue;
      least = distance;
      first = i;
      second = j;
    }
  }
  Cluster& kept = clusters_[first];
  const Cluster& gone = clusters_[second];
  kept.normal_m += gone.normal_m;
  kept.place_m2 += gone.place_m2;
  kept.weight_m += gone.weight_m;
  kept.gap_m = std::min(kept.gap_m, gone.gap_m);
  kept.certain_separation_m = std::min(kept.certain_separation_m, gone.certain_separation_m);
  kept.update();
  std::copy(clusters_.begin() + static_cast<std::ptrdiff_t>(second) + 1,
            clusters_.begin() + static_cast<std::ptrdiff_t>(count_),
            clusters_.begin() + static_cast<std::ptrdiff_t>(second));
  --count_;
}

void ManifoldClusters::finish(ManifoldPoints& into) {
  while (count_ > kMaxManifoldPoints) merge_nearest();
  into.count = count_;
  for (std::size_t i = 0; i < count_; ++i) {
    const Cluster& cluster = clusters_[i];
    into.point[i] = {cluster.direction, cluster.point_m, cluster.gap_m,
                     std::max(cluster.gap_m, cluster.certain_separation_m)};
  }
}

}  // namespace poise::collision
