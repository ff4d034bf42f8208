// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "meshes.h"
#include "poise/assets/mesh_file.h"

namespace poise::geometry {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(ProceduralShape, EveryOneIsClosedOutwardAndAboutAMetreAcross) {
  for (const std::string_view kind : procedural_shapes()) {
    const TriangleMesh mesh = make_procedural_shape(kind).value();
    EXPECT_TRUE(check_closed(mesh).closed()) << kind;
    EXPECT_TRUE(mesh_mass_properties(mesh).ok()) << kind;
    EXPECT_GT(mesh.diagonal_m(), 0.8) << kind;
    EXPECT_LT(mesh.diagonal_m(), 1.8) << kind;
    EXPECT_LE(mesh.triangles.size(), 2000U) << kind;
    TriangleMesh again = mesh;
    const MeshRepair repair = clean_mesh(again, 1e-6);
    EXPECT_EQ(repair.vertices_welded + repair.triangles_discarded, 0U) << kind;
    EXPECT_FALSE(repair.flipped) << kind;
  }
}

TEST(ProceduralShape, VolumesComeCloseToThoseOfTheSmoothShapes) {
  const auto volume = [](std::string_view kind) {
    return mesh_mass_properties(make_procedural_shape(kind).value()).value().volume_m3;
  };
  EXPECT_NEAR(volume("slab"), 0.06, 1e-9);
  EXPECT_NEAR(volume("cube"), 0.343, 1e-9);
  EXPECT_NEAR(volume("l"), (0.64 - 0.3025) * 0.25, 1e-9);
  const double torus = 2 * kPi * kPi * 0.35 * 0.15 * 0.15;
  EXPECT_NEAR(volume("torus"), torus, 0.05 * torus);
  const double bowl = 2 * kPi / 3 * (std::pow(0.5, 3) - std::pow(0.42, 3));
  EXPECT_NEAR(volume("bowl"), bowl, 0.05 * bowl);
  const double disc = kPi * 0.25 * 0.12;
  EXPECT_NEAR(volume("disc"), disc, 0.05 * disc);
  // Three crossed cylinders of radius r and length 2 l: 6 pi r^2 l minus the intersections of two and three of them
  // (Steinmetz: 16/3 r^3 a pair, 8 (2 - sqrt 2) r^3 for all), and six half balls at the ends.
  const double r = 0.12;
  const double l = 0.38;
  const double jack =
      6 * kPi * r * r * l - 3 * 16.0 / 3 * r * r * r + 8 * (2 - std::sqrt(2.0)) * r * r * r + 4 * kPi * r * r * r;
  EXPECT_NEAR(volume("jack"), jack, 0.05 * jack);
}

TEST(ProceduralShape, TheMeshesThatShipAreWhatTheToolMakes) {
  for (const std::string kind : {"jack", "torus", "slab", "l", "bowl"}) {
    const std::filesystem::path file = std::filesystem::path(POISE_SOURCE_DIR) / "scenes/meshes" / (kind + ".obj");
    std::ifstream stream(file, std::ios::binary);
    const std::string shipped((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    const TriangleMesh mesh = make_procedural_shape(kind).value();
    EXPECT_EQ(shipped, obj_text(mesh, "made by: poise shape " + kind)) << file;
    const auto read = read_mesh(file, {});
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read.value().vertices_m, mesh.vertices_m) << kind;
    EXPECT_EQ(read.value().triangles, mesh.triangles) << kind;
  }
}

TEST(ProceduralShape, ComesNearerToTheRoundShapeTheFinerItIs) {
  // A ring of radius R and a tube of radius r have the volume 2 pi^2 R r^2; chords reduce it by a share that falls with
  // the square of their number.
  constexpr double kTorus_m3 = 2 * std::numbers::pi * std::numbers::pi * 0.35 * 0.15 * 0.15;
  const auto missing = [&](int fineness) {
    const TriangleMesh mesh = make_procedural_shape("torus", fineness).value();
    return 1 - mesh_mass_properties(mesh).value().volume_m3 / kTorus_m3;
  };
  EXPECT_NEAR(missing(1) / missing(4), 16, 0.5);
  for (const std::string_view kind : procedural_shapes())
    EXPECT_TRUE(check_closed(make_procedural_shape(kind, 3).value()).closed()) << kind;
}

TEST(ProceduralShape, RefusesAFinenessOutOfRange) {
  for (const int fineness : {0, kMaxFineness + 1}) {
    const auto shape = make_procedural_shape("jack", fineness);
    ASSERT_FALSE(shape.ok());
    EXPECT_EQ(shape.error().message, "fineness = " + std::to_string(fineness) + ", must be from 1 to 16");
  }
}

TEST(ProceduralShape, RefusesAnyOtherNameAndListsThose) {
  const auto shape = make_procedural_shape("teapot");
  ASSERT_FALSE(shape.ok());
  EXPECT_NE(shape.error().message.find("jack torus slab l bowl cube disc"), std::string::npos) << shape.error().message;
}

}  // namespace
}  // namespace poise::geometry
