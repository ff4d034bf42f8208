// SPDX-License-Identifier: MIT
#include "collision/manifold/manifold_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "collision/instruction_sets.h"
#include "collision/shapes.h"

namespace poise::collision {
namespace {

constexpr double kReach = 0.01;
constexpr double kSize = 0.1;

struct NodeContact {
  Vec3 normal, point_m;
  double gap_m, certain_m;
};

// Contacts scattered about some spots, each with a direction of its own; some are out of reach.
std::vector<NodeContact> contacts_about(std::mt19937_64& random, std::size_t spots, std::size_t count) {
  std::vector<NodeContact> all;
  for (std::size_t k = 0; k < count; ++k) {
    const double turn = 2.0 * static_cast<double>(k % spots);
    const Vec3 spot(static_cast<double>(k % spots), 0, 0);
    const Vec3 normal = (Vec3(std::cos(turn), std::sin(turn), 0.3) + random_vector(random, 0.05)).normalized();
    const double gap = kReach - 0.012 * random_vector(random, 1).cwiseAbs().x();
    all.push_back({normal, spot + random_vector(random, 0.02), gap, gap + 0.001});
  }
  return all;
}

// Adds contacts in blocks of at most `block`.
ManifoldPoints clustered(std::span<const NodeContact> all, std::size_t block) {
  ManifoldClusters clusters(kReach, kSize);
  for (std::size_t begin = 0; begin < all.size(); begin += block) {
    NodeContacts lanes;
    const std::size_t count = std::min(block, all.size() - begin);
    for (std::size_t k = 0; k < count; ++k) {
      const NodeContact& contact = all[begin + k];
      lanes.gap_m[k] = static_cast<float>(contact.gap_m);
      lanes.certain_separation_m[k] = static_cast<float>(contact.certain_m);
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        lanes.normal[axis][k] = static_cast<float>(contact.normal[axis]);
        lanes.point_m[axis][k] = static_cast<float>(contact.point_m[axis]);
      }
    }
    clusters.add(lanes, count);
  }
  ManifoldPoints points;
  clusters.write(points);
  return points;
}

TEST(ManifoldClusters, EachSpotBecomesOnePointAtItsWeightedMeans) {
  std::mt19937_64 random(21);
  for (int round = 0; round < 50; ++round) {
    const std::size_t spots = 1 + random() % kMaxManifoldPoints;
    const std::vector<NodeContact> all = contacts_about(random, spots, 40);
    const ManifoldPoints points = clustered(all, 8);
    ASSERT_EQ(points.count, spots);
    for (std::size_t spot = 0; spot < spots; ++spot) {
      Vec3 normal = Vec3::Zero();
      Vec3 point = Vec3::Zero();
      double weight = 0;
      double gap = 1e300;
      for (std::size_t k = spot; k < all.size(); k += spots) {
        const double w = std::max(0.0, kReach - all[k].gap_m);
        normal += w * all[k].normal;
        point += w * all[k].point_m;
        weight += w;
        gap = std::min(gap, all[k].gap_m);
      }
      const auto* const found =
          std::min_element(points.point.begin(), points.point.begin() + static_cast<std::ptrdiff_t>(points.count),
                           [&](const ManifoldPoint& x, const ManifoldPoint& y) {
                             return (x.point_m - point / weight).norm() < (y.point_m - point / weight).norm();
                           });
      EXPECT_LT((found->point_m - point / weight).norm(), 1e-5);
      EXPECT_LT((found->normal - normal.normalized()).norm(), 1e-5);
      EXPECT_NEAR(found->gap_m, gap, 1e-8);
      EXPECT_NEAR(found->certain_separation_m, gap + 0.001, 1e-8);
    }
  }
}

// The same, written plainly: every contact is compared with every cluster, each time.
class PlainClusters {
 public:
  void add(std::span<const NodeContact> block) {
    std::vector<std::size_t> left;
    for (std::size_t k = 0; k < block.size(); ++k) {
      if (weight_of(block[k]) > 0) left.push_back(k);
    }
    while (!left.empty()) {
      std::vector<std::pair<std::size_t, std::size_t>> joined;
      for (const std::size_t k : left) {
        const Cluster as_cluster = begun(block[k]);
        std::size_t nearest = clusters_.size();
        float least = std::numeric_limits<float>::max();
        for (std::size_t c = 0; c < clusters_.size(); ++c) {
          const float distance = distance_of(as_cluster, clusters_[c]);
          if (distance < least) nearest = c;
          least = std::min(least, distance);
        }
        if (least <= 1.0F) joined.emplace_back(k, nearest);
      }
      for (const auto& [k, cluster] : joined) {
        join(begun(block[k]), clusters_[cluster]);
        std::erase(left, k);
      }
      if (left.empty()) break;
      if (clusters_.size() == ClusterState::kMost) merge_nearest();
      clusters_.push_back(begun(block[left.front()]));
      left.erase(left.begin());
    }
    for (Cluster& cluster : clusters_) {
      if (cluster.weight > 1.25F * cluster.mean_weight) update(cluster);
    }
  }
  std::vector<ManifoldPoint> points() {
    for (Cluster& cluster : clusters_) update(cluster);
    std::vector<ManifoldPoint> made;
    for (const Cluster& cluster : clusters_) {
      const double gap = static_cast<double>(cluster.gap);
      made.push_back({Vec3(cluster.direction.cast<double>()).normalized(), cluster.center.cast<double>(), gap,
                      std::max(gap, static_cast<double>(cluster.certain))});
    }
    return made;
  }

 private:
  using Three = Eigen::Vector3f;
  struct Cluster {
    Three normals, points, direction, center;  // sums, and means
    float weight, mean_weight, gap, certain;
  };
  static float weight_of(const NodeContact& contact) {
    return std::max(static_cast<float>(kReach) - static_cast<float>(contact.gap_m), 0.0F);
  }
  static Cluster begun(const NodeContact& contact) {
    const float weight = weight_of(contact);
    const Three normal = contact.normal.cast<float>();
    const Three point = contact.point_m.cast<float>();
    return {weight * normal,
            weight * point,
            normal,
            point,
            weight,
            weight,
            static_cast<float>(contact.gap_m),
            static_cast<float>(contact.certain_m)};
  }
  static float square(const Three& of) { return (of.x() * of.x() + of.y() * of.y()) + of.z() * of.z(); }
  static float distance_of(const Cluster& a, const Cluster& b) {
    const auto inverse_square = static_cast<float>(1.0 / (kSize * kSize));
    return square(a.center - b.center) * inverse_square + square(a.direction - b.direction) * (1.0F / 0.586F);
  }
  static void join(const Cluster& gone, Cluster& kept) {
    kept.normals += gone.normals;
    kept.points += gone.points;
    kept.weight += gone.weight;
    kept.gap = std::min(kept.gap, gone.gap);
    kept.certain = std::min(kept.certain, gone.certain);
  }
  static void update(Cluster& cluster) {
    const float length = std::sqrt(square(cluster.normals));
    if (length > 0) cluster.direction = cluster.normals / length;
    cluster.center = cluster.points / cluster.weight;
    cluster.mean_weight = cluster.weight;
  }
  void merge_nearest() {
    std::pair<std::size_t, std::size_t> nearest{0, 1};
    float least = std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < clusters_.size(); ++i) {
      for (std::size_t j = i + 1; j < clusters_.size(); ++j) {
        const float distance = distance_of(clusters_[i], clusters_[j]);
        if (distance < least) nearest = {i, j};
        least = std::min(least, distance);
      }
    }
    join(clusters_[nearest.second], clusters_[nearest.first]);
    update(clusters_[nearest.first]);
    clusters_.erase(clusters_.begin() + static_cast<std::ptrdiff_t>(nearest.second));
  }

  std::vector<Cluster> clusters_;
};

TEST(ManifoldClusters, AreThoseOfEveryContactComparedWithEveryCluster) {
  std::mt19937_64 random(25);
  for (int round = 0; round < 400; ++round) {
    // From one spot to many that overlap, so that clusters are begun, joined and merged in every order.
    const double spread = 0.03 * (1 + round % 12);
    std::vector<NodeContact> all;
    for (std::size_t k = 0; k < 1 + random() % 60; ++k) {
      const double gap = kReach - 0.012 * random_vector(random, 1).cwiseAbs().x();
      const Vec3 normal = (Vec3::UnitZ() + random_vector(random, 0.1 * (round % 5))).normalized();
      all.push_back({normal, random_vector(random, spread), gap, gap + 0.001});
    }
    const ManifoldPoints points = clustered(all, 8);
    PlainClusters plain;
    for (std::size_t begin = 0; begin < all.size(); begin += 8)
      plain.add(std::span(all).subspan(begin, std::min<std::size_t>(8, all.size() - begin)));
    const std::vector<ManifoldPoint> expected = plain.points();
    ASSERT_EQ(points.count, expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      EXPECT_EQ(points.point[k].normal, expected[k].normal) << round;
      EXPECT_EQ(points.point[k].point_m, expected[k].point_m) << round;
      EXPECT_EQ(points.point[k].gap_m, expected[k].gap_m);
      EXPECT_EQ(points.point[k].certain_separation_m, expected[k].certain_separation_m);
    }
  }
}

TEST(ManifoldClusters, MoreSpotsThanPointsAreMergedAndNoneIsLost) {
  std::mt19937_64 random(22);
  for (const std::size_t spots : {9U, 12U, 16U}) {
    const std::vector<NodeContact> all = contacts_about(random, spots, 80);
    const ManifoldPoints points = clustered(all, 8);
    EXPECT_EQ(points.count, kMaxManifoldPoints);
    double nearest = 1e300;
    double least = 1e300;
    for (const NodeContact& contact : all) least = std::min(least, contact.gap_m);
    for (std::size_t k = 0; k < points.count; ++k) nearest = std::min(nearest, points.point[k].gap_m);
    EXPECT_NEAR(nearest, least, 1e-8);
  }
}

TEST(ManifoldClusters, WhatIsOutOfReachMakesNoPoint) {
  const NodeContact far{Vec3::UnitX(), Vec3::Zero(), kReach + 0.001, kReach + 0.001};
  EXPECT_EQ(clustered(std::vector<NodeContact>(20, far), 8).count, 0U);
}

TEST(ManifoldClusters, BlocksOfAnySizeGiveTheSamePointsWhereSpotsAreFarApart) {
  std::mt19937_64 random(23);
  const std::vector<NodeContact> all = contacts_about(random, 4, 60);
  const ManifoldPoints expected = clustered(all, 8);
  for (const std::size_t block : {1U, 3U, 7U}) {
    const ManifoldPoints points = clustered(all, block);
    ASSERT_EQ(points.count, expected.count);
    for (std::size_t k = 0; k < points.count; ++k)
      EXPECT_LT((points.point[k].point_m - expected.point[k].point_m).norm(), 1e-5);
  }
}

TEST(ManifoldClusters, EveryInstructionSetGivesTheSameBits) {
  const auto all_points = [] {
    std::mt19937_64 random(24);
    std::vector<double> figures;
    for (int round = 0; round < 50; ++round) {
      const ManifoldPoints points = clustered(contacts_about(random, 1 + random() % 11, 50), 8);
      for (std::size_t k = 0; k < points.count; ++k) {
        for (Eigen::Index axis = 0; axis < 3; ++axis)
          figures.insert(figures.end(), {points.point[k].normal[axis], points.point[k].point_m[axis]});
        figures.push_back(points.point[k].gap_m);
      }
    }
    return figures;
  };
  const std::vector<double> expected = all_points();
  EXPECT_GT(expected.size(), 500U);
  on_every_instruction_set([&] { EXPECT_EQ(all_points(), expected); });
}

}  // namespace
}  // namespace poise::collision
