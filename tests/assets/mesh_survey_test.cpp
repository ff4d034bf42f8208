// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <string>

#include "geometry/bvh/triangle_bvh.h"
#include "meshes.h"
#include "poise/assets/mesh_file.h"

// Every file of Debian's assimp-testmodels in the supported formats (docs/sphere-trees.md has the list).
namespace poise {
namespace {

namespace fs = std::filesystem;

const fs::path kModels = "/usr/share/assimp/models";
// Triangles. Three larger meshes are only read, since their trees would take seconds each.
constexpr std::size_t kLargestBuilt = 20000;

/// The refused files, with a part of the message. Each was checked by hand; no other file may be refused.
const std::map<std::string, std::string> kRefused{
    {"OBJ/number_formats.obj", "line 11: z of a vertex is '3.1+e2', must be a finite number"},
    {"OBJ/point_cloud.obj", "3 vertices, but no face with three corners"},
    {"OBJ/testline.obj", "8 vertices, but no face with three corners"},
    {"OBJ/testpoints.obj", "8 vertices, but no face with three corners"},
    {"OFF/invalid.off", "announces 4 faces in 9 bytes, must have room for them"},
    {"PLY/issue623.ply", "has no element 'face'"},
    {"PLY/points.ply", "has no element 'face'"},
    {"PLY/pond.0.ply", "has no element 'face'"},
    {"glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", "vertex 0 is (-inf, -0.5, 0.5), must be finite"},
    {"glTF2/IndexOutOfRange/AllIndicesOutOfRange.gltf", "indices: value 0 = 65535, must be below 24"},
    {"glTF2/IndexOutOfRange/IndexOutOfRange.gltf", "indices: value 0 = 255, must be below 24"},
    {"glTF2/MissingBin/BoxTextured.gltf", "names the file 'BoxTextured0.bin', which cannot be read"},
    {"glTF2/RecursiveNodes/RecursiveNodes.gltf", "nodes[0] is its own descendant or has two parents"},
    {"glTF2/SchemaFailures/sceneWrongType.gltf", "names the file 'BoxTextured0.bin', which cannot be read"},
    {"glTF2/TestNoRootNode/NoScene.gltf", "has no scene"},
    {"glTF2/TestNoRootNode/SceneWithoutNodes.gltf", "has no triangle, and no vertex either"},
    {"glTF2/draco/2CylinderEngine.gltf", "compressed by KHR_draco_mesh_compression, must be decompressed before"},
    {"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf",
     "1024 vertices, but no face with three corners"},
    {"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_01.gltf",
     "8 vertices, but no face with three corners"},
    {"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_02.gltf",
     "4 vertices, but no face with three corners"},
    {"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_03.gltf",
     "5 vertices, but no face with three corners"},
    {"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_07.gltf",
     "1024 vertices, but no face with three corners"},
    {"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_08.gltf",
     "4 vertices, but no face with three corners"},
    {"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_09.gltf",
     "4 vertices, but no face with three corners"},
    {"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_10.gltf",
     "4 vertices, but no face with three corners"},
    {"glTF2/wrongTypes/badArray.gltf", "meshes[0].primitives must be a list"},
    {"invalid/OutOfMemory.off", "announces 353535235358 vertices in 288 bytes"},
    {"invalid/empty.obj", "is empty"},
    {"invalid/empty.off", "is empty"},
    {"invalid/empty.ply", "is empty"},
    {"invalid/malformed2.obj", "line 23: a face has 0 corners, must have at least 3"},
    {"invalid/malformed.obj", "line 28: a corner of a face is '0', must be the number of a vertex"},
};

/// Files in the supported formats below a folder of the package, sorted by name, as paths relative to the package.
std::vector<std::string> files_below(const std::string& folder) {
  std::vector<std::string> files;
  if (!fs::exists(kModels / folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(kModels / folder)) {
    std::string extension = entry.path().extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const char* ours : {".obj", ".stl", ".ply", ".off", ".gltf", ".glb"}) {
      if (extension == ours) files.push_back(fs::relative(entry.path(), kModels).string());
    }
  }
  std::ranges::sort(files);
  return files;
}

void expect_sound_tree(const TriangleMesh& mesh, const std::string& file) {
  const auto tree = build_sphere_tree(mesh, {.depth = 1, .preset = TreePreset::Fast});
  ASSERT_TRUE(tree.ok()) << file << ": " << tree.error().message;
  const std::size_t levels = std::size_t{tree.value().depth()} + 1;
  for (const Vec3& p : test::surface_points(mesh, 300))
    ASSERT_EQ(test::levels_covered(tree.value(), p), levels) << file;
  const geometry::TriangleBvh bvh(mesh);
  Vec3 low = mesh.vertices_m[0];
  Vec3 high = low;
  for (const Vec3& v : mesh.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  std::mt19937_64 random(5);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = test::random_in_box(random, low, high);
    if (bvh.inside(p)) {
      ASSERT_EQ(test::levels_covered(tree.value(), p), levels) << file;
    }
  }
}

class Survey : public testing::TestWithParam<const char*> {};

TEST_P(Survey, FilesGiveSoundTreesOrAreRefusedForTheReasonThatIsThere) {
  const std::vector<std::string> files = files_below(GetParam());
  if (files.empty()) GTEST_SKIP() << "assimp-testmodels is not installed";
  for (const std::string& file : files) {
    const auto mesh = read_mesh(kModels / file, {});
    const auto refused = kRefused.find(file);
    if (refused != kRefused.end()) {
      ASSERT_FALSE(mesh.ok()) << file;
      EXPECT_NE(mesh.error().message.find(refused->second), std::string::npos) << mesh.error().message;
      continue;
    }
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    if (mesh.value().triangles.size() <= kLargestBuilt) expect_sound_tree(mesh.value(), file);
  }
}

std::string folder_name(const testing::TestParamInfo<const char*>& info) { return info.param; }

INSTANTIATE_TEST_SUITE_P(AssimpTestModels, Survey,
                         testing::Values("OBJ", "OFF", "PLY", "STL", "glTF", "glTF2", "invalid"), folder_name);

TEST(SurveyTable, HoldsOnlyFilesThatAreThereAndLeavesFourFifthsOfThoseWithASurface) {
  const std::vector<std::string> files = files_below("");
  if (files.empty()) GTEST_SKIP() << "assimp-testmodels is not installed";
  std::size_t without_surface = 0;
  for (const auto& [file, reason] : kRefused) {
    EXPECT_TRUE(std::ranges::binary_search(files, file)) << file;
    const bool nothing = reason.find("no face with three") != std::string::npos ||
                         reason.find("no element") != std::string::npos ||
                         reason.find("is empty") != std::string::npos || reason.find("no scene") != std::string::npos ||
                         reason.find("no vertex") != std::string::npos;
    without_surface += nothing ? 1U : 0U;
  }
  const std::size_t sound = files.size() - kRefused.size();
  EXPECT_GE(5 * sound, 4 * (files.size() - without_surface));
}

}  // namespace
}  // namespace poise
