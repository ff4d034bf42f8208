// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <numbers>

#include "meshes.h"

namespace poise {
namespace {

using test::ball_mesh;
using test::box_mesh;
using test::moved;

TriangleMesh open_box(const Vec3& size_m) {
  TriangleMesh mesh = box_mesh(size_m);
  mesh.triangles.resize(10);
  return mesh;
}

TriangleMesh square_sheet() {
  TriangleMesh sheet;
  sheet.vertices_m = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  return sheet;
}

bool says(const MeshReport& report, const std::string& words) { return report.text.find(words) != std::string::npos; }

TEST(WindingMass, OfClosedMeshesIsTheExactOneWithinTheErrorItStates) {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (const TriangleMesh& mesh :
       {ball_mesh(1, 3), test::torus_mesh(0.7, 0.2, 24, 16), moved(box_mesh({1, 0.2, 3}), 1, turn, {100, -50, 20})}) {
    const SampledMass sampled = winding_mass_properties(mesh).value();
    const MassProperties exact = mesh_mass_properties(mesh).value();
    EXPECT_LE(std::abs(sampled.mass.volume_m3 - exact.volume_m3), sampled.volume_error_m3);
    EXPECT_LT(sampled.volume_error_m3, 0.02 * exact.volume_m3);
    EXPECT_EQ(sampled.certain_share, 1);
    EXPECT_LT((sampled.mass.center_of_mass_m - exact.center_of_mass_m).norm(), 2e-3 * mesh.diagonal_m());
    EXPECT_LT((sampled.mass.inertia_m5 - exact.inertia_m5).norm(), 0.02 * exact.inertia_m5.norm());
  }
}

TEST(WindingMass, OfABoxWithAHoleInItIsNearlyThatOfTheBox) {
  // A part of the lid is missing; far from it the winding number is as for the closed box.
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  const std::array<std::uint32_t, 3> last = mesh.triangles.back();
  mesh.triangles.pop_back();
  const Vec3 middle = (mesh.vertices_m[last[0]] + mesh.vertices_m[last[1]] + mesh.vertices_m[last[2]]) / 3;
  for (std::size_t i = 0; i < 3; ++i) mesh.vertices_m.emplace_back(0.8 * middle + 0.2 * mesh.vertices_m[last[i]]);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const std::uint32_t next = (i + 1) % 3;
    mesh.triangles.push_back({last[i], last[next], 8 + next});
    mesh.triangles.push_back({last[i], 8 + next, 8 + i});
  }
  EXPECT_EQ(check_closed(mesh).open_edges, 3U);
  const SampledMass sampled = winding_mass_properties(mesh).value();
  EXPECT_NEAR(sampled.mass.volume_m3, 1, 0.01);
  EXPECT_LT((sampled.mass.inertia_m5 - Mat3::Identity() / 6).norm(), 0.005);
}

TEST(WindingMass, IsTheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = open_box({1, 2, 3});
  const SampledMass one = winding_mass_properties(mesh, 1).value();
  const SampledMass four = winding_mass_properties(mesh, 4).value();
  EXPECT_EQ(one.mass.volume_m3, four.mass.volume_m3);
  EXPECT_EQ(one.mass.inertia_m5, four.mass.inertia_m5);
  EXPECT_EQ(one.certain_share, four.certain_share);
}

TEST(WindingMass, OfASheetIsNothing) { EXPECT_EQ(winding_mass_properties(square_sheet()).value().mass.volume_m3, 0); }

TEST(ShellMass, OfARectangleIsThatOfAPlate) {
  const double t = 0.1;
  const MassProperties mass = shell_mass_properties(square_sheet(), t).value();
  EXPECT_NEAR(mass.volume_m3, 2 * t, 1e-15);
  EXPECT_LT((mass.center_of_mass_m - Vec3(1, 0.5, 0)).norm(), 1e-15);
  const Vec3 plate = 2 * t / 12 * Vec3(1 + t * t, 4 + t * t, 5);
  EXPECT_LT((mass.inertia_m5 - plate.asDiagonal().toDenseMatrix()).norm(), 1e-15);
}

TEST(ShellMass, OfABallIsThatOfAHollowBall) {
  const double radius = 2;
  const double thickness = 1e-3;
  const MassProperties mass =
      shell_mass_properties(moved(ball_mesh(radius, 5), 1, Mat3::Identity(), {1000, 0, 0}), thickness).value();
  const double volume = 4 * std::numbers::pi * radius * radius * thickness;
  EXPECT_NEAR(mass.volume_m3 / volume, 1, 2e-3);
  EXPECT_LT((mass.center_of_mass_m - Vec3(1000, 0, 0)).norm(), 1e-9);
  const double moment = 2.0 / 3 * volume * radius * radius;
  EXPECT_LT((mass.inertia_m5 - moment * Mat3::Identity()).norm(), 5e-3 * moment);
}

TEST(ShellMass, RefusesThicknessesOutOfRangeAndMeshesWithoutArea) {
  for (const double thickness : {0.0, -1.0, 1e-10, 1e10, std::nan("")}) {
    const auto mass = shell_mass_properties(square_sheet(), thickness);
    ASSERT_FALSE(mass.ok()) << thickness;
    EXPECT_NE(mass.error().message.find("shell_thickness_m = "), std::string::npos) << mass.error().message;
  }
  TriangleMesh needle = square_sheet();
  needle.vertices_m = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  EXPECT_NE(shell_mass_properties(needle, 1).error().message.find("area"), std::string::npos);
  EXPECT_NE(shell_mass_properties({}, 1).error().message.find("no triangle"), std::string::npos);
}

TEST(MeshFinding, OfAClosedMeshIsItsExactMass) {
  const MeshReport report = assess_mesh(ball_mesh(1, 4)).value();
  EXPECT_TRUE(report.exact_mass);
  EXPECT_EQ(report.solidity, Solidity::Solid);
  EXPECT_EQ(report.triangles, 2048U);
  EXPECT_EQ(report.vertices, 1026U);
  EXPECT_EQ(report.pieces, 1U);
  EXPECT_EQ(report.holes, 0U);
  EXPECT_EQ(report.volume_error_m3, 0);
  EXPECT_TRUE(says(report, "closed: 2,048 triangles in 1 piece; 4.")) << report.text;
}

TEST(MeshFinding, OfAnOpenMeshSaysWhereItsInsideIs) {
  const MeshReport report = assess_mesh(open_box({1, 2, 3})).value();
  EXPECT_FALSE(report.exact_mass);
  EXPECT_EQ(report.solidity, Solidity::Solid);
  EXPECT_EQ(report.edges.open_edges, 4U);
  EXPECT_EQ(report.holes, 1U);
  EXPECT_GT(report.volume_m3, 4);
  EXPECT_LT(report.volume_m3, 7);
  EXPECT_GT(report.volume_error_m3, 0);
  EXPECT_TRUE(says(report, "open: 4 edges with one triangle alone (1 rim)")) << report.text;
  EXPECT_TRUE(says(report, "winding number is above one half")) << report.text;
}

TEST(MeshFinding, OfASheetAsksForAThickness) {
  TriangleMesh bent = square_sheet();
  bent.vertices_m[2].z() = 0.1;
  for (const TriangleMesh& sheet : {square_sheet(), bent}) {
    const MeshReport report = assess_mesh(sheet).value();
    EXPECT_EQ(report.solidity, Solidity::Shell);
    EXPECT_NEAR(report.area_m2, 2, 0.02);
    EXPECT_TRUE(says(report, "give a thickness")) << report.text;
  }
  TriangleMesh both_faces = square_sheet();
  both_faces.triangles.push_back({0, 2, 1});
  both_faces.triangles.push_back({0, 3, 2});
  const MeshReport report = assess_mesh(both_faces).value();
  EXPECT_EQ(report.solidity, Solidity::Shell);
  EXPECT_TRUE(says(report, "closed, but it encloses nothing")) << report.text;
}

TEST(MeshFinding, OfAThinPlateWithAHoleIsSolid) {
  TriangleMesh plate = box_mesh({1, 1, 0.002});
  plate.triangles.pop_back();  // half of a narrow side is missing
  const MeshReport report = assess_mesh(plate).value();
  EXPECT_EQ(report.solidity, Solidity::Solid) << report.text;
  EXPECT_NEAR(report.volume_m3, 0.002, 0.0001);
}

TEST(MeshFinding, TellsPiecesThatOverlap) {
  TriangleMesh two = ball_mesh(1, 3);
  const TriangleMesh other = moved(ball_mesh(1, 3), 1, Mat3::Identity(), {0.5, 0, 0});
  const auto base = static_cast<std::uint32_t>(two.vertices_m.size());
  two.vertices_m.insert(two.vertices_m.end(), other.vertices_m.begin(), other.vertices_m.end());
  for (const auto& t : other.triangles) two.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  const MeshReport report = assess_mesh(two).value();
  EXPECT_EQ(report.pieces, 2U);
  EXPECT_TRUE(says(report, "overlap")) << report.text;
  EXPECT_FALSE(says(assess_mesh(ball_mesh(1, 3)).value(), "overlap"));
}

TEST(MeshFinding, RefusesWhatIsNoMesh) {
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  mesh.triangles[5][1] = 8;
  EXPECT_NE(assess_mesh(mesh).error().message.find("vertex 8 of 8"), std::string::npos);
  mesh = box_mesh(Vec3::Ones());
  mesh.vertices_m[3].y() = std::nan("");
  EXPECT_NE(assess_mesh(mesh).error().message.find("not finite"), std::string::npos);
  EXPECT_NE(assess_mesh({}).error().message.find("no triangle"), std::string::npos);
}

}  // namespace
}  // namespace poise
