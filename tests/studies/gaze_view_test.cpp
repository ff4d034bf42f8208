// SPDX-License-Identifier: MIT
#include "studies/gaze_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace poise::app {
namespace {

/// A slab of points around `middle_m`, 20 by 20 by 2 metres.
std::vector<Vec3> slab(const Vec3& middle_m) {
  std::vector<Vec3> points_m;
  for (int x = -10; x <= 10; ++x) {
    for (int y = -10; y <= 10; ++y) {
      for (int z = -1; z <= 1; ++z) points_m.push_back(middle_m + Vec3(x, y, z));
    }
  }
  return points_m;
}

TEST(GazeView, JustHoldsTheHeap) {
  for (const Vec3& middle_m : {Vec3(0, 0, 1), Vec3(40, -7, 3)}) {
    const std::vector<Vec3> heap = slab(middle_m);
    const View view = overlooking(heap).view;
    EXPECT_TRUE(view.present);
    EXPECT_NEAR(view.forward.norm(), 1, 1e-12);
    EXPECT_NEAR(view.forward.dot(view.up), 0, 1e-12);
    double left = 1, right = 0, inside = 0;
    for (const Vec3& point_m : heap) {
      const ScreenPlace place = on_screen(view, point_m);
      left = std::min(left, place.across);
      right = std::max(right, place.across);
      inside += place.inside ? 1 : 0;
    }
    EXPECT_GT(inside, 0.8 * static_cast<double>(heap.size()));
    EXPECT_NEAR(left, 1 - right, 1e-9) << "in the middle";
    EXPECT_LT(left, 0.05) << "from edge to edge";
  }
}

TEST(GazeView, IsNotMadeSmallByABodyThatHasLeftTheHeap) {
  std::vector<Vec3> heap = slab({0, 0, 1});
  const View view = overlooking(heap).view;
  heap.emplace_back(1e6, 1e6, -1e9);
  EXPECT_NEAR((overlooking(heap).view.position_m - view.position_m).norm(), 0, 1e-9);
  EXPECT_TRUE(overlooking(std::vector<Vec3>(1, Vec3(1, 2, 3))).view.position_m.allFinite()) << "one body alone";
}

TEST(GazeView, APointIsSeenWhereItsRayMeetsThePicture) {
  const View view = overlooking(slab({0, 0, 1})).view;
  const double tangent_up = std::tan(15 * kGazeDegreeRad);
  const Vec3 right = view.forward.cross(view.up);
  const Vec3 ahead_m = view.position_m + 7 * view.forward;
  const ScreenPlace place = on_screen(view, ahead_m + 7 * tangent_up * (0.4 * 16 / 9 * right + 0.5 * view.up));
  EXPECT_NEAR(place.across, 0.7, 1e-12);
  EXPECT_NEAR(place.down, 0.25, 1e-12);
  EXPECT_TRUE(place.inside);
  EXPECT_FALSE(on_screen(view, ahead_m + 7 * tangent_up * 1.01 * view.up).inside) << "above the picture";
  EXPECT_FALSE(on_screen(view, view.position_m - view.forward).inside) << "behind the viewer";
}

TEST(GazeView, TheGazePointsAreOnTheHeapLeftCentreAndRight) {
  const GazeCamera camera = overlooking(slab({40, -7, 3}));
  const double low_x_m = 40 - 9;  // a twentieth of the slab is beside its box
  for (const auto& [point, share] : {std::pair{0U, 0.15}, {1U, 0.5}, {2U, 0.85}}) {
    EXPECT_NEAR(eccentricity_rad(gazing_at(camera, point), Vec3(low_x_m + share * 18, -7, 3)), 0, 1e-6);
  }
  EXPECT_EQ(gazing_at(camera, 1).gaze, camera.view.gaze);
  EXPECT_LT(camera.gazes[0].x(), 0) << "left is -x for one who looks along y";
  EXPECT_NEAR(camera.gazes[0].x(), -camera.gazes[2].x(), 1e-12);
  const double apart_rad = eccentricity_rad(gazing_at(camera, 0), camera.view.position_m + camera.gazes[2]);
  EXPECT_GT(apart_rad, 20 * kGazeDegreeRad) << "what is near one is far from the other";
  EXPECT_EQ(eccentricity_rad(camera.view, camera.view.position_m), 0);
}

}  // namespace
}  // namespace poise::app
