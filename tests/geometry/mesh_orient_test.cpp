// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numbers>

#include "geometry/mesh/mesh_volume.h"
#include "meshes.h"

namespace poise {
namespace {

using test::box_mesh;
using test::moved;

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto base = static_cast<std::uint32_t>(a.vertices_m.size());
  a.vertices_m.insert(a.vertices_m.end(), b.vertices_m.begin(), b.vertices_m.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  return a;
}

TriangleMesh inside_out(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[0], t[2]);
  return mesh;
}

TriangleMesh box_at(double x, double size) {
  return moved(box_mesh(Vec3::Constant(size)), 1, Mat3::Identity(), {x, 0, 0});
}

RC_GTEST_PROP(Orientation, TrianglesTurnedAtRandomComeRightAgain, (std::uint32_t seed)) {
  std::mt19937_64 random(seed);
  const TriangleMesh right = seed % 2 == 0 ? test::torus_mesh(0.7, 0.2, 12, 8) : test::ball_mesh(1, 2);
  TriangleMesh mesh = right;
  std::size_t turned = 0;
  for (auto& t : mesh.triangles) {
    if (random() % 3 != 0) continue;
    std::swap(t[1], t[2]);
    ++turned;
  }
  const MeshRepair repair = clean_mesh(mesh, 1e-9);
  RC_ASSERT(check_closed(mesh).closed());
  RC_ASSERT(std::abs(geometry::mesh_volume(mesh).volume_m3 - geometry::mesh_volume(right).volume_m3) < 1e-12);
  RC_ASSERT(repair.triangles_turned == std::min(turned, right.triangles.size() - turned));
  RC_ASSERT(repair.flipped == (2 * turned > right.triangles.size()));
}

TEST(Orientation, APieceBesideAnotherIsTurnedByItself) {
  TriangleMesh mesh = joined(box_at(0, 1), inside_out(box_at(3, 2)));
  const MeshRepair repair = clean_mesh(mesh, 1e-9);
  EXPECT_EQ(repair.pieces_turned, 1U);
  EXPECT_EQ(repair.triangles_turned, 0U);
  EXPECT_FALSE(repair.flipped);
  EXPECT_NEAR(mesh_mass_properties(mesh).value().volume_m3, 9, 1e-12);
}

TEST(Orientation, ACavityStaysACavity) {
  TriangleMesh hollow = joined(inside_out(box_at(0.1, 1)), box_at(0, 2));
  EXPECT_EQ(clean_mesh(hollow, 1e-9).pieces_turned, 0U);
  EXPECT_NEAR(mesh_mass_properties(hollow).value().volume_m3, 7, 1e-12);
}

TEST(Orientation, AHollowBoxThatIsInsideOutComesRightWithItsCavityAndWhatLiesInThat) {
  const TriangleMesh core = inside_out(box_at(0.1, 0.5));
  TriangleMesh mesh = joined(joined(core, box_at(0.1, 1)), inside_out(box_at(0, 2)));
  const MeshRepair repair = clean_mesh(mesh, 1e-9);
  EXPECT_EQ(repair.pieces_turned, 3U);
  EXPECT_TRUE(repair.flipped);
  EXPECT_NEAR(mesh_mass_properties(mesh).value().volume_m3, 7.125, 1e-12);
}

TEST(Orientation, APieceThatOnlyOverlapsAnotherDoesNotLieInIt) {
  TriangleMesh mesh =
      joined(box_at(0, 2), inside_out(moved(box_mesh({0.5, 0.4, 0.4}), 1, Mat3::Identity(), {1, 0, 0})));
  // Inside the box's range of y and z, but half of it protrudes.
  EXPECT_EQ(clean_mesh(mesh, 1e-9).pieces_turned, 1U);
  EXPECT_NEAR(mesh_mass_properties(mesh).value().volume_m3, 8.08, 1e-12);
}

TEST(Orientation, AnOpenBoxThatIsInsideOutIsTurned) {
  TriangleMesh mesh = inside_out(box_at(5, 1));
  mesh.triangles.resize(10);  // one face is missing
  EXPECT_TRUE(clean_mesh(mesh, 1e-9).flipped);
  const auto& t = mesh.triangles[0];  // of the lower face in box_mesh
  const Vec3 normal =
      (mesh.vertices_m[t[1]] - mesh.vertices_m[t[0]]).cross(mesh.vertices_m[t[2]] - mesh.vertices_m[t[0]]);
  EXPECT_LT(normal.z(), 0);
}

TEST(Orientation, ASheetKeepsTheSideThatTheFileGives) {
  for (const bool turned : {false, true}) {
    TriangleMesh sheet;
    sheet.vertices_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    if (turned) sheet = inside_out(sheet);
    const auto before = sheet.triangles;
    EXPECT_EQ(clean_mesh(sheet, 1e-9).pieces_turned, 0U);
    EXPECT_EQ(sheet.triangles, before);
  }
}

TEST(Orientation, AMoebiusStripIsNoWorseThanItWas) {
  TriangleMesh strip;
  constexpr std::uint32_t kSteps = 9;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSteps;
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    const Vec3 arm = 0.2 * (std::cos(angle / 2) * out + std::sin(angle / 2) * Vec3::UnitZ());
    strip.vertices_m.emplace_back(out - arm);
    strip.vertices_m.emplace_back(out + arm);
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const std::uint32_t a = 2 * i;
    const bool last = i + 1 == kSteps;
    const std::uint32_t low = last ? 1 : a + 2;
    const std::uint32_t high = last ? 0 : a + 3;
    strip.triangles.push_back({a, low, high});
    strip.triangles.push_back({a, high, a + 1});
  }
  TriangleMesh cleaned = strip;
  clean_mesh(cleaned, 1e-9);
  EXPECT_LE(check_closed(cleaned).inconsistent_edges, 1U);
  // The orientation only gets more consistent: three reversed triangles are corrected.
  TriangleMesh worse = strip;
  for (const std::size_t t : {std::size_t{3}, std::size_t{7}, std::size_t{12}})
    std::swap(worse.triangles[t][0], worse.triangles[t][1]);
  EXPECT_GT(check_closed(worse).inconsistent_edges, 5U);
  clean_mesh(worse, 1e-9);
  EXPECT_LE(check_closed(worse).inconsistent_edges, 1U);
}

TEST(Orientation, TwoBoxesThatShareAnEdgeAreTwoPieces) {
  // Four triangles at the common edge, so orientations do not propagate over it.
  TriangleMesh mesh = joined(box_at(0, 1), inside_out(moved(box_mesh(Vec3::Ones()), 1, Mat3::Identity(), {1, 1, 0})));
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  const MeshRepair repair = clean_mesh(mesh, 1e-9);
  EXPECT_EQ(repair.triangles_turned, 1U);
  EXPECT_EQ(repair.pieces_turned, 1U);
  EXPECT_EQ(check_closed(mesh).crowded_edges, 1U);
  EXPECT_NEAR(mesh_mass_properties(mesh).value().volume_m3, 2, 1e-12);
}

RC_GTEST_PROP(Orientation, ASecondCleaningTurnsNothing, (std::uint32_t seed)) {
  std::mt19937_64 random(seed);
  TriangleMesh mesh;
  for (int box = 0; box < 6; ++box) {
    const Vec3 at = test::random_in_box(random, -Vec3::Ones(), Vec3::Ones());
    TriangleMesh next = moved(box_mesh(Vec3::Constant(0.1 + test::uniform(random))), 1, Mat3::Identity(), at);
    for (auto& t : next.triangles) {
      if (random() % 4 == 0) std::swap(t[0], t[1]);
    }
    next.triangles.resize(12 - random() % 3);
    mesh = joined(mesh, next);
  }
  clean_mesh(mesh, 1e-9);
  const auto once = mesh.triangles;
  const MeshRepair repair = clean_mesh(mesh, 1e-9);
  RC_ASSERT(repair.triangles_turned == 0U);
  RC_ASSERT(repair.pieces_turned == 0U);
  RC_ASSERT(mesh.triangles == once);
}

}  // namespace
}  // namespace poise
