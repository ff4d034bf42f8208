// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "poise/assets/mesh_file.h"
#include "poise/scene/scene.h"
#include "scene/import/gltf_import.h"
#include "scene/import/mjcf_import.h"
#include "scene/import/scene_draft.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

/// Why a draft is no scene; empty if it is one.
std::string draft_refusal(const io::SceneDraft& draft, const io::DraftSettings& settings, const io::SaveMesh& save) {
  io::WrittenDraft written;
  const Result<std::string> text = io::draft_text(draft, settings, "s.json", save, written);
  return text ? std::string() : text.error().message;
}

const std::string kShelf = POISE_SOURCE_DIR "/scenes/robots/shelf.gltf";

TEST(ImportDraft, BodiesThatAreAlikeShareAShapeAndAFile) {
  const TemporaryFolder folder;
  const std::string pair = "<freejoint/><geom size='0.1'/><geom type='box' size='0.1 0.1 0.1' pos='0.2 0 0'/></body>";
  const auto draft = io::import_mjcf("<mujoco><worldbody><body pos='0 0 1'>" + pair + "<body pos='0 0 2'>" + pair +
                                         "<geom type='box' size='1 1 1'/><geom type='box' size='1 1 1' pos='3 0 0'/>"
                                         "</worldbody></mujoco>",
                                     "m.xml", "", false);
  ASSERT_TRUE(draft.ok()) << draft.error().message;
  const auto written = io::write_draft(draft.value(), {}, folder.file("s.json"));
  ASSERT_TRUE(written.ok()) << written.error().message;
  EXPECT_EQ(written.value().shapes, 2U);
  EXPECT_EQ(written.value().mesh_files, 2U);
  const Result<Scene> scene = read_scene(folder.file("s.json"));
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value().bodies.size(), 4U);
  const auto mesh = read_mesh(folder.file("s-meshes/box-1.obj"), {});
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_NEAR(mesh_mass_properties(mesh.value()).value().volume_m3, 8, 1e-12);
}

TEST(ImportDraft, TwoBoxesFaceToFaceAreASolid) {
  const TemporaryFolder folder;
  const auto draft = io::import_mjcf(
      "<mujoco><worldbody><body><freejoint/><geom type='box' size='0.1 0.1 0.1'/><geom type='box' size='0.1 0.1 0.1' "
      "pos='0 0 0.2'/></body></worldbody></mujoco>",
      "m.xml", "", false);
  ASSERT_TRUE(io::write_draft(draft.value(), {}, folder.file("s.json")).ok());
  const auto mesh = read_mesh(folder.file("s-meshes/union-1.obj"), {});
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_TRUE(check_closed(mesh.value()).closed());
  EXPECT_NEAR(mesh_mass_properties(mesh.value()).value().volume_m3, 0.016, 1e-12);
}

// A model of 20 bytes a solid, each of a mesh of its own: what is made of it is counted before it is held.
TEST(ImportDraft, RefusesMoreTrianglesThanItWrites) {
  io::SceneDraft draft;
  draft.name = "made";
  io::DraftSolid solid;
  solid.kind = io::SolidKind::Ellipsoid;
  solid.half_m = {1, 2, 3};
  io::DraftBody body;
  body.solids.assign(3, solid);
  draft.bodies.push_back(body);
  std::size_t saved = 0;
  const auto save = [&](const std::filesystem::path&, const std::string&) {
    ++saved;
    return Status(Done{});
  };
  io::DraftSettings settings;
  settings.most_written = 3 * 960;
  EXPECT_EQ(draft_refusal(draft, settings, save), "");
  EXPECT_EQ(saved, 1U);
  --settings.most_written;
  EXPECT_EQ(draft_refusal(draft, settings, save), "needs meshes of more than 2879 triangles");
  settings.most_of_mesh = settings.most_written;
  ++settings.most_written;
  draft.bodies.front().name = "crowd";
  EXPECT_EQ(draft_refusal(draft, settings, save),
            "body 'crowd' needs a mesh of more than 2879 triangles for its 3 solids");
  EXPECT_EQ(saved, 1U);
}

// A mesh of the model is read for each solid that it is a part of.
TEST(ImportDraft, RefusesMeshesThatAreReadTooOften) {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  io::SceneDraft draft;
  draft.name = "made";
  draft.meshes.push_back({"pyramid", {}, mesh, Mat3::Identity()});
  io::DraftSolid solid;
  solid.kind = io::SolidKind::Mesh;
  io::DraftBody body;
  body.solids.assign(10, solid);
  draft.bodies.push_back(body);
  io::DraftSettings settings;
  settings.most_read = 80;
  const auto save = [](const std::filesystem::path&, const std::string&) { return Status(Done{}); };
  EXPECT_EQ(draft_refusal(draft, settings, save), "");
  settings.most_read = 79;
  EXPECT_EQ(draft_refusal(draft, settings, save),
            "its meshes have more than 79 vertices and triangles together, each as often as it is used");
}

TEST(ImportDraft, NamesMeshesInOneLine) {
  io::SceneDraft draft;
  draft.name = "made";
  draft.meshes.push_back({"a\nb", "/nowhere/x\n.stl", nullptr, Mat3::Identity()});
  io::DraftSolid solid;
  solid.kind = io::SolidKind::Mesh;
  io::DraftBody body;
  body.solids.push_back(solid);
  draft.bodies.push_back(body);
  const auto save = [](const std::filesystem::path&, const std::string&) { return Status(Done{}); };
  EXPECT_EQ(draft_refusal(draft, {}, save), "mesh 'a?b': /nowhere/x?.stl: cannot be read: no such file");
  auto triangle = std::make_shared<TriangleMesh>();
  triangle->vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle->triangles = {{0, 1, 2}};
  draft.meshes[0].mesh = triangle;
  io::WrittenDraft written;
  // What it says of the mesh does not depend on whether the text is a scene.
  (void)io::draft_text(draft, {}, "s.json", save, written);
  EXPECT_EQ(written.warnings,
            std::vector<std::string>{"mesh 'a?b' encloses no volume: it is its surface, 0.001 m thick"});
}

TEST(ImportDraft, OverwritesNoMeshOfTheModel) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("s-meshes"));
  const std::string own = folder.file("s-meshes/mesh-1.obj");
  std::filesystem::copy_file(POISE_SOURCE_DIR "/scenes/meshes/slab.obj", own);
  const auto draft = io::import_mjcf(
      "<mujoco><asset><mesh name='m' file='s-meshes/mesh-1.obj' scale='1 2 1'/></asset><worldbody><geom type='mesh' "
      "mesh='m'/></worldbody></mujoco>",
      "m.xml", folder.path(), false);
  const auto written = io::write_draft(draft.value(), {}, folder.file("s.json"));
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().message, "would overwrite its mesh " + own + ", the scene needs another name");
  EXPECT_EQ(contents(own), contents(POISE_SOURCE_DIR "/scenes/meshes/slab.obj"));
}

TEST(ImportDraft, ThatIsRefusedLeavesAllAsItWas) {
  const TemporaryFolder folder;
  const auto draft = [&](const std::string& size, const std::string& more) {
    const auto read = io::import_mjcf(
        "<mujoco><asset><mesh name='gone' file='gone.obj'/></asset><worldbody>"
        "<geom type='cylinder' size='" +
            size + "'/>" + more + "</worldbody></mujoco>",
        "m.xml", folder.path(), false);
    EXPECT_TRUE(read.ok());
    return read.value();
  };
  ASSERT_TRUE(io::write_draft(draft("1 2", ""), {}, folder.file("s.json")).ok());
  const std::string mesh = folder.file("s-meshes/cylinder-1.obj");
  const std::string before = contents(mesh);
  ASSERT_FALSE(before.empty());
  EXPECT_FALSE(io::write_draft(draft("1 3", "<geom type='mesh' mesh='gone'/>"), {}, folder.file("s.json")).ok());
  EXPECT_EQ(contents(mesh), before);
  std::filesystem::create_symlink("/dev/full", folder.file("full.json"));
  EXPECT_FALSE(io::write_draft(draft("1 2", ""), {}, folder.file("full.json")).ok());
  EXPECT_FALSE(std::filesystem::exists(folder.file("full-meshes")));
}

TEST(ImportDraft, OfWhichAMeshCannotBeWrittenLeavesTheOthersAsTheyWere) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, double length_m) {
    const std::string shape = "<geom type='cylinder' size='1 ";
    const auto draft = io::import_mjcf("<mujoco><worldbody>" + shape + std::to_string(length_m) + "'/>" + shape +
                                           std::to_string(2 * length_m) + "'/></worldbody></mujoco>",
                                       "m.xml", folder.path(), false);
    return io::write_draft(draft.value(), {}, folder.file(name)).ok();
  };
  ASSERT_TRUE(write("s.json", 1));
  const std::string first = contents(folder.file("s-meshes/cylinder-1.obj"));
  const std::string scene = contents(folder.file("s.json"));
  ASSERT_FALSE(first.empty());
  const std::string second = folder.file("s-meshes/cylinder-2.obj");
  ASSERT_TRUE(std::filesystem::remove(second));
  std::filesystem::create_directory(second);
  EXPECT_FALSE(write("s.json", 3));
  EXPECT_EQ(contents(folder.file("s-meshes/cylinder-1.obj")), first);
  EXPECT_EQ(contents(folder.file("s.json")), scene);
}

TEST(ImportGltf, MakesABodyOfEachNodeWithAMesh) {
  io::GltfImportSettings settings;
  settings.fixed = {"plank"};
  settings.floor = true;
  const auto draft = io::import_gltf(kShelf, settings);
  ASSERT_TRUE(draft.ok()) << draft.error().message;
  ASSERT_EQ(draft.value().bodies.size(), 3U) << "nodes without a mesh are no bodies";
  const io::DraftBody& box = draft.value().bodies[0];
  EXPECT_EQ(box.name, "box");
  EXPECT_TRUE(box.dynamic);
  // y of the file is z of the scene; two metres up, turned by 45 degrees about the upward axis.
  EXPECT_LE((box.position_m - Vec3(0, 0, 2)).norm(), 1e-15);
  EXPECT_LE((box.orientation * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-7);
  EXPECT_LE((box.orientation * Vec3::UnitX() - Vec3(std::sqrt(0.5), std::sqrt(0.5), 0)).norm(), 1e-7);
  const io::DraftBody& plank = draft.value().bodies[1];
  EXPECT_FALSE(plank.dynamic);
  EXPECT_EQ(plank.position_m, Vec3(0, 0, 1));
  const io::DraftBody& floor = draft.value().bodies[2];
  EXPECT_TRUE(floor.solids.empty());
  EXPECT_NEAR(floor.position_m.z(), 0.95, 1e-7) << "below the plank, which is 0.1 m thick";
  const TemporaryFolder folder;
  ASSERT_TRUE(io::write_draft(draft.value(), {}, folder.file("s.json")).ok());
  const auto mesh = read_mesh(folder.file("s-meshes/mesh-2.obj"), {});
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_NEAR(mesh_mass_properties(mesh.value()).value().volume_m3, 0.2, 1e-7);
}

TEST(ImportGltf, ScalesPlacesFloorAndMeshesAlike) {
  io::GltfImportSettings settings;
  settings.fixed = {"plank"};
  settings.floor = true;
  settings.scale = 0.001;
  const auto draft = io::import_gltf(kShelf, settings);
  ASSERT_TRUE(draft.ok()) << draft.error().message;
  EXPECT_LE((draft.value().bodies[0].position_m - Vec3(0, 0, 0.002)).norm(), 1e-15);
  EXPECT_NEAR(draft.value().bodies[2].position_m.z(), 0.00095, 1e-10);
  const TemporaryFolder folder;
  ASSERT_TRUE(io::write_draft(draft.value(), {}, folder.file("s.json")).ok());
  const auto mesh = read_mesh(folder.file("s-meshes/mesh-2.obj"), {});
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_NEAR(mesh_mass_properties(mesh.value()).value().volume_m3, 0.2e-9, 1e-16);
}

TEST(ImportGltf, TakesMirrorsAndShearsIntoTheMesh) {
  const TemporaryFolder folder;
  std::string text = contents(kShelf);
  const auto volume = [&](const std::string& matrix) {
    const std::size_t begin = text.find("\"scale\": [2");
    std::string changed = text;
    changed.replace(begin, text.find(']', begin) + 1 - begin, matrix);
    std::ofstream(folder.file("c.gltf")) << changed;
    const auto draft = io::import_gltf(folder.file("c.gltf"), {});
    EXPECT_TRUE(draft.ok()) << draft.error().message;
    EXPECT_TRUE(io::write_draft(draft.value(), {}, folder.file("s.json")).ok());
    return mesh_mass_properties(read_mesh(folder.file("s-meshes/mesh-2.obj"), {}).value()).value().volume_m3;
  };
  EXPECT_NEAR(volume("\"scale\": [-2, 3, 1]"), 6, 1e-6) << "not inside out";
  EXPECT_NEAR(volume("\"matrix\": [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]"), 1, 1e-6);
}

TEST(ImportGltf, NodesOfOneMeshShareAShapeInSinglePrecisionToo) {
  geometry::GltfNodes nodes;
  nodes.meshes.push_back(
      {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}});
  nodes.meshes.front().vertices_m.emplace_back(0, -100, 0);  // no corner of a triangle
  for (int i = 0; i < 40; ++i) {
    const Quat turn(Eigen::AngleAxisd(0.3 * i, Vec3(1, 0.2 * i, -2).normalized()));
    Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
    transform.topLeftCorner<3, 3>() = (turn.toRotationMatrix() * 0.4).cast<float>().cast<double>();
    nodes.nodes.push_back({"n", 0, transform});
  }
  io::GltfImportSettings settings;
  settings.scale = 0.01;
  settings.floor = true;
  const auto draft = io::gltf_draft(std::move(nodes), settings);
  ASSERT_TRUE(draft.ok()) << draft.error().message;
  EXPECT_EQ(draft.value().meshes.size(), 1U);
  EXPECT_GT(draft.value().bodies.back().position_m.z(), -0.005) << "the floor is below what there is";
}

TEST(ImportGltf, WhatItCannotReadRightIsRefused) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& from, const std::string& to) {
    std::string text = contents(kShelf);
    text.replace(text.find(from), from.size(), to);
    std::ofstream(folder.file("c.gltf")) << text;
    const auto draft = io::import_gltf(folder.file("c.gltf"), {});
    return draft.ok() ? std::string() : draft.error().message.substr(folder.file("c.gltf").size());
  };
  EXPECT_EQ(
      refusal("{", "{\"extensionsRequired\": [\"KHR_physics_rigid_bodies\"], "),
      ": extensionsRequired has \"KHR_physics_rigid_bodies\", must be extensions that are read or change no shape");
  EXPECT_EQ(refusal("{", "{\"extensionsRequired\": [\"KHR_materials_unlit\"], "), "");
  EXPECT_EQ(refusal("\"version\"", "\"minVersion\": \"3.0\", \"version\""),
            ": asset.minVersion = \"3.0\", must be 1 or 2");
  EXPECT_NE(refusal("\"scale\": [2, 0.1, 1]", "\"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2]")
                .find("].matrix must end its four columns with 0, 0, 0 and 1"),
            std::string::npos);
}

io::DraftSolid box_at(const Vec3& half_m, const Vec3& position_m) {
  io::DraftSolid box;
  box.kind = io::SolidKind::Box;
  box.half_m = half_m;
  box.position_m = position_m;
  return box;
}

// As one mesh, whose vertices are welded when it is read, they would lose the triangles that they share.
TEST(ImportDraft, SolidsThatLieOnEachOtherWeighWhatTheyWeigh) {
  const Vec3 half(0.5, 0.5, 0.5);
  struct Case {
    std::vector<io::DraftSolid> solids;
    double volume_m3;
    Vec3 center_m;
  };
  const std::vector<Case> cases = {
      {{box_at(half, {0, 0, 0}), box_at(half, {0, 0, 0}), box_at(half, {3, 0, 0})}, 3, {1, 0, 0}},
      {{box_at(half, {0, 0, 0}), box_at({0.5, 0.5, 1}, {0, 0, 0.5})}, 3, {0, 0, 1.0 / 3}},
      {{box_at(half, {0, 0, 0}), box_at(half, {0, 0, 1})}, 2, {0, 0, 0.5}},
  };
  for (const Case& of : cases) {
    io::SceneDraft draft;
    draft.name = "s";
    io::DraftBody& body = draft.bodies.emplace_back();
    body.name = "b";
    body.dynamic = true;
    body.solids = of.solids;
    const TemporaryFolder folder;
    const auto written = io::write_draft(draft, {}, folder.file("s.json"));
    ASSERT_TRUE(written.ok()) << written.error().message;
    const auto mesh = read_mesh(folder.file("s-meshes/union-1.obj"), {});
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_TRUE(check_closed(mesh.value()).closed());
    const MassProperties properties = mesh_mass_properties(mesh.value()).value();
    EXPECT_NEAR(properties.volume_m3, of.volume_m3, 1e-4);
    EXPECT_LT((properties.center_of_mass_m - of.center_m).norm(), 1e-4) << properties.center_of_mass_m.transpose();
  }
}

TEST(ImportDraft, WhatIsTooThinToBeReadAgainIsRefused) {
  io::SceneDraft draft;
  draft.bodies.emplace_back().solids = {box_at({1000, 1000, 0.001}, {0, 0, 0})};
  const TemporaryFolder folder;
  const auto written = io::write_draft(draft, {}, folder.file("s.json"));
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().message.find("a box of half sizes [1000.0,1000.0,0.001] m is too thin, must be thicker"),
            std::string::npos)
      << written.error().message;
}

TEST(ImportDraft, ASheetBesideSolidsIsRefused) {
  io::SceneDraft draft;
  draft.meshes.push_back({"sheet",
                          {},
                          std::make_shared<const TriangleMesh>(TriangleMesh{
                              {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)}, {{0, 1, 2}, {0, 2, 3}}}),
                          Mat3::Identity()});
  io::DraftBody& body = draft.bodies.emplace_back();
  body.name = "b";
  body.dynamic = true;
  io::DraftSolid sheet;
  sheet.kind = io::SolidKind::Mesh;
  io::DraftSolid solid;
  solid.kind = io::SolidKind::Box;
  solid.half_m = Vec3(0.5, 0.5, 0.5);
  body.solids = {sheet, solid};
  const TemporaryFolder folder;
  const auto written = io::write_draft(draft, {}, folder.file("s.json"));
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().message.find("must have solids alone or none"), std::string::npos)
      << written.error().message;
}

TEST(ImportGltf, IsRefusedWithTheNode) {
  io::GltfImportSettings settings;
  settings.fixed = {"eye"};
  EXPECT_EQ(io::import_gltf(kShelf, settings).error().message,
            kShelf + ": --static = 'eye', must be the name of a node with a mesh");
  const TemporaryFolder folder;
  std::string text = contents(kShelf);
  text.replace(text.find("[2, 0.1, 1]"), 11, "[0, 0.1, 1]");
  std::ofstream(folder.file("flat.gltf")) << text;
  EXPECT_EQ(io::import_gltf(folder.file("flat.gltf"), {}).error().message,
            folder.file("flat.gltf") +
                ": node 'plank': its transform must be finite, within 1000000000 and without a scale of 0");
}

}  // namespace
}  // namespace poise::testing
