// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "poise/scene/scene.h"
#include "scene/scene_shapes.h"
#include "scene/scene_text.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

/// A tetrahedron whose corners distinguish the axes.
void write_mesh(const TemporaryFolder& folder) {
  std::ofstream(folder.file("m.obj")) << "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
}

std::string mesh_scene(const std::string& members) {
  return R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": {"s": {"mesh": {"file": "m.obj", "depth": 0)" +
         members + R"(}}}, "bodies": [{"shape": "s", "material": "m"}]})";
}

Vec3 corner_after(const TemporaryFolder& folder, const std::string& members, std::size_t corner) {
  const Result<Scene> scene = parse_scene(mesh_scene(members), "s.json", folder.path());
  EXPECT_TRUE(scene) << scene.error().message;
  const Result<TriangleMesh> mesh = io::scene_mesh(scene.value(), std::get<MeshSource>(scene.value().shapes[0].source));
  EXPECT_TRUE(mesh) << mesh.error().message;
  return mesh.value().vertices_m[corner];
}

TEST(MeshTurn, BringsTheNamedAxisToPlusZWithoutRounding) {
  const TemporaryFolder folder;
  write_mesh(folder);
  EXPECT_EQ(corner_after(folder, R"(, "up": "x")", 1), Vec3(0, 0, 1));
  EXPECT_EQ(corner_after(folder, R"(, "up": "-x")", 1), Vec3(0, 0, -1));
  EXPECT_EQ(corner_after(folder, R"(, "up": "y")", 2), Vec3(0, 0, 2));
  EXPECT_EQ(corner_after(folder, R"(, "up": "-y")", 2), Vec3(0, 0, -2));
  EXPECT_EQ(corner_after(folder, R"(, "up": "z")", 3), Vec3(0, 0, 3));
  EXPECT_EQ(corner_after(folder, R"(, "up": "-z")", 3), Vec3(0, 0, -3));
  EXPECT_EQ(corner_after(folder, "", 3), Vec3(0, 0, 3));
  EXPECT_EQ(corner_after(folder, R"(, "up": "y")", 1), Vec3(1, 0, 0)) << "x stays";
}

TEST(MeshTurn, ByAQuaternionIsNormalised) {
  const TemporaryFolder folder;
  write_mesh(folder);
  EXPECT_EQ(corner_after(folder, R"(, "rotation_wxyz": [3, 3, 0, 0])", 2), Vec3(0, 0, 2));
  const Vec3 turned = corner_after(folder, R"(, "rotation_wxyz": [0.9659258262890683, 0, 0, 0.25881904510252074])", 1);
  EXPECT_NEAR((turned - Vec3(std::sqrt(0.75), 0.5, 0)).norm(), 0, 1e-15);
}

TEST(MeshTurn, MovesTheCentreOfMassOfTheShape) {
  const TemporaryFolder folder;
  write_mesh(folder);
  const Result<Scene> scene = parse_scene(mesh_scene(R"(, "up": "y")"), "s.json", folder.path());
  ASSERT_TRUE(scene);
  const Result<SceneRun> run = SceneRun::create(scene.value(), {});
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_NEAR((run.value().shapes()[0]->origin_offset_m - Vec3(0.25, -0.75, 0.5)).norm(), 0, 1e-12);
}

TEST(MeshTurn, IsRefusedWhereItIsSaidTwiceOrWrongly) {
  EXPECT_EQ(refusal(mesh_scene(R"(, "up": "y", "rotation_wxyz": [1, 0, 0, 0])")),
            "s.json: shapes.s.mesh.rotation_wxyz: not with up, which is a rotation too");
  EXPECT_EQ(refusal(mesh_scene(R"(, "up": "w")")),
            "s.json: shapes.s.mesh.up = \"w\", must be x, -x, y, -y, z or -z; did you mean \"x\"?");
  EXPECT_EQ(refusal(mesh_scene(R"(, "rotation_wxyz": [0, 0, 0, 0])")),
            "s.json: shapes.s.mesh.rotation_wxyz = [0, 0, 0, 0], must not be zero");
}

}  // namespace
}  // namespace poise::testing
