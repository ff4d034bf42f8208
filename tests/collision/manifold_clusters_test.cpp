// SPDX-License-Identifier: MIT
#include "collision/manifold/manifold_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
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

TEST(ManifoldClusters, MoreSpotsThanPointsAreMergedAndNoneIsLost) {
  std::mt19937_64 random(22);
  for (const std::size_t spots : {5U, 8U, 11U}) {
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
