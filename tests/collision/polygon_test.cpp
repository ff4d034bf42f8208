// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "collision/front/pair_refinement.h"
#include "collision/near_touch.h"
#include "collision/polygon_pairs.h"
#include "poise/assets/mesh_file.h"

namespace poise::collision {
namespace {

namespace fs = std::filesystem;

constexpr Level kDepth = 2;  // deeper trees take too long to build for a test; bench_tree_query covers the third level

const fs::path kMeshes = "/usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry";

OracleShape oracle_shape(const char* file) {
  TriangleMesh mesh = read_mesh(kMeshes / file, {}).value();
  center_mesh(mesh);
  return make_oracle_shape(mesh, test::shared_tree(mesh, kDepth));
}

// Number of levels with a front, from 1: kDepth if the pair is never separated.
int levels_with_a_front(const PairFrame& frame, std::span<FrontPool> pools) {
  pools[0].clear();
  SinglePair pair;
  pair.deepest = deepest_level(*frame.a, *frame.b, kMaxTreeDepth);
  int levels = 0;
  while (pair.refinable()) {
    LevelProgress progress = begin_level(pair, pools[0]);
    while (run_quantum(frame, pools, 0, 64, progress) == Quantum::More) {
    }
    publish_level(frame, Mat3::Identity(), progress, pair, pair);
    if (!pair.apart) ++levels;
  }
  return levels;
}

const OracleShape* shapes() {
  static const OracleShape both[] = {oracle_shape("Base.obj"), oracle_shape("Wrist3.obj")};
  return both;
}

// Growth of the oracle's distance when b moves, divided by the length of the move. It is the normal where the surfaces
// are separated and one pair of features is the nearest.
Vec3 gradient(const OracleShape& a, const OracleShape& b, const PosedPair& posed, double step_m) {
  Vec3 slope;
  for (int axis = 0; axis < 3; ++axis) {
    const auto distance = [&](double side) {
      Pose moved = posed.b;
      moved.position_m[axis] += side * step_m;
      return a.oracle.distance_m(posed.a, b.oracle, moved);
    };
    slope[axis] = (distance(1) - distance(-1)) / (2 * step_m);
  }
  return slope;
}

struct Agreement {
  int touching = 0, apart = 0, disagreed = 0;
  int gaps = 0, normals = 0, normals_off = 0, lifted = 0, lifted_off = 0;
};

// Compares one pose with the oracle.
void compare(const OracleShape& a, const OracleShape& b, const PosedPair& posed, std::span<FrontPool> pools,
             bool with_normals, Agreement& sum) {
  const double size = std::min(a.diagonal_m, b.diagonal_m);
  const double band = 1e-4 * size;
  const double margin = 5e-3 * size;
  const auto ask = [&](const PosedPair& at) {
    return solve_by_polygons(make_pair_frame(a.shape, at.a, b.shape, at.b, margin, 0), pools).contact;
  };
  const PairContact contact = ask(posed);
  const bool touches = a.oracle.touches(posed.a, b.oracle, posed.b);
  const double distance = touches ? 0.0 : a.oracle.distance_m(posed.a, b.oracle, posed.b);
  const bool says = contact.present && contact.estimated_separation_m <= 0;
  touches ? ++sum.touching : ++sum.apart;
  const bool hair = distance < band && contact.present && std::abs(contact.estimated_separation_m) < band;
  if (says != touches && !hair) ++sum.disagreed;
  const double within = std::cos(5 * M_PI / 180);
  if (!touches && distance < margin - band) {
    ++sum.gaps;
    ASSERT_TRUE(contact.present);
    ASSERT_NEAR(contact.estimated_separation_m, distance, 1e-6 * size);
  }
  if (!with_normals) return;
  // One softness length away from every other pair of features; otherwise the result is correctly a mean of both.
  const double step = 2e-4 * size;
  const auto one_normal = [&](const PosedPair& at, const PairContact& said, int& asked, int& off) {
    const Vec3 slope = gradient(a, b, at, step);
    if (slope.norm() < 0.9999) return;
    ++asked;
    if ((at.a.rotation * said.direction).dot(slope.normalized()) < within) ++off;
  };
  if (!touches && distance > 2 * step && distance < margin - 2 * step)
    one_normal(posed, contact, sum.normals, sum.normals_off);
  if (touches && contact.present && -contact.estimated_separation_m < 2e-3 * size) {
    // Moved out along the result's own normal, the surfaces must be just separated, with the normal perpendicular to
    // them.
    PosedPair lifted = posed;
    lifted.b.position_m += posed.a.rotation * contact.direction * (3 * step - contact.estimated_separation_m);
    one_normal(lifted, contact, sum.lifted, sum.lifted_off);
  }
}

TEST(PolygonsOfMeshes, AgreeWithTheOracleAboutTouchGapAndNormal) {
  if (!fs::exists(kMeshes)) GTEST_SKIP() << "libsimbody-dev is not installed";
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 18U);
  std::mt19937_64 random(22);
  Agreement sum;
  PosedPair found;
  for (int round = 0; round < 1000; ++round) {
    const OracleShape& a = shapes()[round / 5 % 2];
    const OracleShape& b = shapes()[round / 10 % 2];
    // Finding a first contact with the oracle is slow, so each one is used for five poses around it.
    if (round % 5 == 0) found = pose_near_first_touch(a, b, 4e-3, random);
    PosedPair posed = found;
    if (round % 5 != 0) {
      const double size = std::min(a.diagonal_m, b.diagonal_m);
      posed.b.position_m += random_vector(random, 3e-3 * size);
      posed.b.rotation = turned(uniform(random, -5e-3, 5e-3), random_vector(random, 1)) * posed.b.rotation;
    }
    ASSERT_NO_FATAL_FAILURE(compare(a, b, posed, pools, round % 5 == 0, sum)) << "round " << round;
  }
  EXPECT_EQ(sum.disagreed, 0);
  EXPECT_GT(sum.touching, 300);
  EXPECT_GT(sum.apart, 300);
  EXPECT_GT(sum.gaps, 300);
  EXPECT_GT(sum.normals, 80);
  EXPECT_EQ(sum.normals_off, 0);
  EXPECT_GT(sum.lifted, 30);
  EXPECT_LE(sum.lifted_off, sum.lifted / 25);
}

TEST(TreesOfMeshes, NoLevelIsEmptyWhereTrianglesMeet) {
  if (!fs::exists(kMeshes)) GTEST_SKIP() << "libsimbody-dev is not installed";
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 16U);
  std::mt19937_64 random(21);
  int touching = 0;
  int told_apart = 0;
  for (int round = 0; round < 2000; ++round) {
    const OracleShape& a = shapes()[random() % 2];
    const OracleShape& b = shapes()[random() % 2];
    PosedPair posed;
    if (round % 10 == 0) {
      posed = pose_near_first_touch(a, b, 5e-3, random);
    } else {
      posed = {random_pose(random, 10), random_pose(random, 0)};
      const double distance = uniform(random, 0.1, 1) * (a.shape.bounding_radius_m + b.shape.bounding_radius_m);
      posed.b.position_m = posed.a.position_m + distance * random_vector(random, 1).normalized();
    }
    const PairFrame frame = make_pair_frame(a.shape, posed.a, b.shape, posed.b, 0, 0);
    const int levels = levels_with_a_front(frame, pools);
    if (a.oracle.touches(posed.a, b.oracle, posed.b)) {
      ++touching;
      ASSERT_EQ(levels, int{kDepth}) << "round " << round;
    } else if (levels < int{kDepth}) {
      ++told_apart;
    }
  }
  EXPECT_GT(touching, 300);
  EXPECT_GT(told_apart, 300);
}

}  // namespace
}  // namespace poise::collision
