// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "meshes.h"
#include "poise/assets/mesh_file.h"

namespace poise {
namespace {

namespace fs = std::filesystem;

const fs::path kModels = "/usr/share/assimp/models";
const fs::path kSimbody = "/usr/share/doc/simbody/examples/src";

/// A separate folder for each test, removed with its content.
class MeshFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("poise_mesh_" + std::string(info->name()) + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  std::string refusal(const fs::path& file, const MeshReadOptions& options = {}) const {
    const auto mesh = read_mesh(file, options);
    if (mesh.ok()) return "not refused";
    EXPECT_EQ(mesh.error().message.find(file.string() + ": "), 0U) << mesh.error().message;
    EXPECT_EQ(mesh.error().message.find('\n'), std::string::npos) << mesh.error().message;
    return mesh.error().message;
  }
  fs::path folder_;
};

constexpr const char* kTetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

TEST_F(MeshFile, ObjIsReadInDoublePrecision) {
  std::string text = kTetrahedron;
  text.replace(text.find("1 0 0"), 1, "1.0000000000001");
  const auto mesh = read_mesh(write("a.obj", text), {});
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().vertices_m[1].x(), 1.0000000000001);
}

TEST_F(MeshFile, ObjPolygonsSlashesNegativeIndicesAndContinuedLinesAreRead) {
  const std::string text =
      "# a cube\nmtllib nowhere.mtl\nvn 0 0 1\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
      "usemtl x\ng part\nf 4//1 3//1 \\\r\n2//1 1//1\nf 5 6 7 8\nf 1 2 6 5\nf -6 -5 -1 -2\nf 2 3 7 6\nf 1 5 8 4\n";
  const auto mesh = read_mesh(write("a.obj", text), {.scale = 0.5});
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().triangles.size(), 12U);
  EXPECT_NEAR(mesh_mass_properties(mesh.value()).value().volume_m3, 0.125, 1e-15);
}

TEST_F(MeshFile, TheSameTetrahedronComesOutOfEveryFormat) {
  const std::string stl =
      "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid t\n";
  const std::string off = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 "
      "2 3\n";
  for (const fs::path& file :
       {write("a.obj", kTetrahedron), write("a.STL", stl), write("a.off", off), write("a.ply", ply)}) {
    MeshRepair repair;
    const auto mesh = read_mesh(file, {}, &repair);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh.value().vertices_m.size(), 4U) << file;
    EXPECT_FALSE(repair.flipped);
    const auto mass = mesh_mass_properties(mesh.value());
    ASSERT_TRUE(mass.ok()) << mass.error().message;
    EXPECT_NEAR(mass.value().volume_m3, 1.0 / 6, 1e-15) << file;
  }
}

TEST_F(MeshFile, WhatCannotBeReadIsRefusedWithItsRule) {
  fs::create_directories(folder_ / "folder.obj");
  const std::string nan_off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n";
  const std::vector<std::pair<fs::path, std::string>> cases{
      {folder_ / "missing.obj", "no such file"},
      {folder_ / "folder.obj", "not a file"},
      {write("empty.stl", ""), "is empty"},
      {write("a.xyz", "1 2 3"), "extension '.xyz' is not known"},
      {write("noextension", "1 2 3"), "extension '' is not known"},
      {write("novertex.obj", "# nothing\n"), "no triangle"},
      {write("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n"), "no triangle"},
      {write("flat.obj", "v 0 0 0\nv 1 0 0\nf 1 2 2\n"), "no triangle"},
      {write("nan.obj", std::string("# x\nv 0 nan 0\n") + kTetrahedron), "line 2: y of a vertex is 'nan'"},
      {write("inf.obj", std::string("v 0 0 -inf\n") + kTetrahedron), "line 1: z of a vertex is '-inf'"},
      {write("word.obj", std::string("v 0 0 zero\n") + kTetrahedron), "line 1: z of a vertex is 'zero'"},
      {write("short.obj", std::string("v 0 0\n") + kTetrahedron), "line 1: z of a vertex is ''"},
      {write("huge.obj", std::string("v 1e400 0 0\n") + kTetrahedron), "line 1: x of a vertex is '1e400'"},
      {write("index.obj", std::string(kTetrahedron) + "f 1 2 9\n"),
       "line 9: a face names vertex 9 of 4, counted from 1, must exist"},
      {write("zero.obj", std::string(kTetrahedron) + "f 0 1 2\n"),
       "line 9: a corner of a face is '0', must be the number of a vertex"},
      {write("negative.obj", std::string(kTetrahedron) + "f -9 1 2\n"), "must exist"},
      {write("text.stl", "this is no STL file at all"), "must begin with 'solid' or with a head of 84 bytes"},
      {write("text.glb", "this is no glTF file at all"), "not valid JSON"},
      {write("text.gltf", "{\"asset\": "), "not valid JSON"},
      {write("nan.off", nan_off), "line 5: y of vertex 2 is 'nan', must be a finite number"},
      {write("many.off", "OFF\n999999999999 1 0\n0 0 0\n"), "announces 999999999999 vertices"},
      {write("many.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\nelement face 1\nend_header\n"),
       "announces 4000000000"},
      {write("index.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
             "face 1\n"
             "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 70000\n"),
       "face 0: a face names vertex 70000 of 3"},
  };
  for (const auto& [file, rule] : cases) {
    const std::string message = refusal(file);
    EXPECT_NE(message, "not refused") << file;
    EXPECT_NE(message.find(rule), std::string::npos) << message;
  }
}

TEST_F(MeshFile, APipeOrDeviceIsRefusedInsteadOfWaitedFor) {
  for (const char* name : {"p.obj", "p.stl", "p.ply", "p.off", "p.gltf", "p.glb"}) {
    ASSERT_EQ(::mkfifo((folder_ / name).c_str(), 0600), 0);
    EXPECT_NE(refusal(folder_ / name).find("not a file: a folder, a pipe or a device"), std::string::npos) << name;
  }
  fs::create_symlink("/dev/zero", folder_ / "zero.stl");
  EXPECT_NE(refusal(folder_ / "zero.stl").find("not a file"), std::string::npos);
}

TEST_F(MeshFile, ObjWithAByteOrderMarkIsRead) {
  const std::string text = kTetrahedron;
  std::string big = "\xfe\xff";
  std::string little = "\xff\xfe";
  for (const char c : text) {
    big += std::string(1, '\0') + c;
    little += c + std::string(1, '\0');
  }
  for (const fs::path& file :
       {write("u8.obj", "\xef\xbb\xbf" + text), write("big.obj", big), write("little.obj", little)}) {
    const auto mesh = read_mesh(file, {});
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh.value().triangles.size(), 4U) << file;
  }
}

/// The bytes of a buffer with a triangle and its three indices, 44 in all: three points of floats, three shorts, two
/// bytes of padding.
std::string triangle_bytes() {
  const std::array<float, 9> points{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::array<std::uint16_t, 4> indices{0, 1, 2, 0};
  std::string bytes(44, '\0');
  std::memcpy(bytes.data(), points.data(), 36);
  std::memcpy(bytes.data() + 36, indices.data(), 8);
  return bytes;
}

/// A glTF file of that triangle, with the marked positions of the text filled in.
std::string triangle_gltf(const std::string& buffer, const std::string& top = "", const std::string& primitive = "") {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "translation": [5, 0, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1)" +
         primitive + R"(}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                  {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
    "buffers": [{"byteLength": 44)" +
         buffer + "}]" + top + "}";
}

std::string glb(std::string text, const std::string& binary) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto number = [](std::size_t n) {
    const auto small = static_cast<std::uint32_t>(n);
    return std::string(reinterpret_cast<const char*>(&small), 4);
  };
  std::string file = "glTF" + number(2) + number(28 + text.size() + binary.size());
  file += number(text.size()) + "JSON" + text;
  return file + number(binary.size()) + std::string("BIN\0", 4) + binary;
}

TEST_F(MeshFile, GltfIsReadForItsShapeFromAnyOfItsPlaces) {
  write("my points.bin", triangle_bytes());
  const std::string broken_colours = R"(, "materials": [{"name": 7, "pbrMetallicRoughness": "none"}], "textures": 3)";
  const std::vector<fs::path> files{
      write("file.gltf", triangle_gltf(R"(, "uri": "my%20points.bin")")),
      write("inside.glb", glb(triangle_gltf(""), triangle_bytes())),
      write("colours.gltf", triangle_gltf(R"(, "uri": "my points.bin")", broken_colours, R"(, "material": 0)")),
  };
  for (const fs::path& file : files) {
    const auto mesh = read_mesh(file, {});
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    ASSERT_EQ(mesh.value().triangles.size(), 1U) << file;
    EXPECT_EQ(mesh.value().vertices_m[1], Vec3(6, 0, 0)) << file;
  }
}

TEST_F(MeshFile, GltfThatIsCutOffOrNamesWhatIsNotThereIsRefused) {
  const std::string whole = glb(triangle_gltf(""), triangle_bytes());
  const std::vector<std::pair<fs::path, std::string>> cases{
      {write("missing.gltf", triangle_gltf(R"(, "uri": "nowhere.bin")")),
       "buffer 0 names the file 'nowhere.bin', which cannot be read"},
      {write("nothing.gltf", triangle_gltf("")), "buffer 0 names no file, and nothing is in this one"},
      {write("header.glb", whole.substr(0, 15)), "ends within its header"},
      {write("text.glb", whole.substr(0, 100)), "bytes of JSON are announced"},
      {write("binary.glb", whole.substr(0, whole.size() - 10)), "is cut off"},
      {write("version.glb", "glTF" + std::string(1, 9) + whole.substr(5)), "version 9, must be 1 or 2"},
      {write("short.gltf", triangle_gltf(R"(, "uri": "short.bin")")),
       "bufferViews[0] must lie in the 30 bytes of its buffer"},
      {write("noscene.gltf", R"({"asset": {"version": "2.0"}, "nodes": []})"), "has no scene"},
      {write("scene.gltf", R"({"asset": {"version": "2.0"}, "scene": 2, "scenes": [{}, {}]})"),
       "scene = 2, must be one of 2 scenes"},
      {write("list.gltf", "[1, 2]"), "must be a JSON object"},
      {write("half.gltf", "{\"asset\": "), "not valid JSON"},
  };
  write("short.bin", triangle_bytes().substr(0, 30));
  for (const auto& [file, rule] : cases) {
    const std::string message = refusal(file);
    EXPECT_NE(message, "not refused") << file;
    EXPECT_NE(message.find(rule), std::string::npos) << message;
  }
}

TEST_F(MeshFile, GltfThatNamesAPipeADeviceOrNoNameIsRefused) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe.bin").c_str(), 0600), 0);
  for (const char* uri : {"pipe.bin", "/dev/zero", "/dev/tty", ".", "a%00b"}) {
    const std::string message = refusal(write("uri.gltf", triangle_gltf(fmt::format(R"(, "uri": "{}")", uri))));
    EXPECT_NE(message.find(fmt::format("buffer 0 names the file '{}', which ", uri)), std::string::npos) << message;
  }
}

TEST_F(MeshFile, NoGltfCutOffAnywhereBreaksTheReader) {
  const std::string whole = glb(triangle_gltf(""), triangle_bytes());
  for (std::size_t size = 0; size < whole.size(); size += size < 40 || size + 80 > whole.size() ? 1U : 53U) {
    EXPECT_NE(refusal(write("cut.glb", whole.substr(0, size))), "not refused") << size;
  }
}

TEST_F(MeshFile, CoordinatesAreCheckedAfterScaling) {
  const fs::path file = write("a.obj", kTetrahedron);
  EXPECT_NE(refusal(file, {.scale = 1e10}).find("within 1000000000 m"), std::string::npos);
  EXPECT_NE(refusal(file, {.scale = 1e-10}).find("must be at least 1e-09 m"), std::string::npos);
  for (const double scale : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_NE(refusal(file, {.scale = scale}).find("must be finite and > 0"), std::string::npos) << scale;
  }
  for (const double weld : {-1e-9, 0.2, std::nan("")}) {
    EXPECT_NE(refusal(file, {.weld_relative = weld}).find("weld_relative"), std::string::npos) << weld;
  }
}

TEST_F(MeshFile, TransformsOfNodesAreAppliedAndMeshesMerged) {
  const fs::path file = kModels / "glTF/TwoBoxes/TwoBoxes.gltf";
  if (!fs::exists(file)) GTEST_SKIP() << "assimp-testmodels is not installed";
  const auto mesh = read_mesh(file, {});
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().triangles.size(), 24U);
  // A unit cube, and one with half the edge.
  EXPECT_NEAR(mesh_mass_properties(mesh.value()).value().volume_m3, 1.125, 1e-9);
}

TEST_F(MeshFile, FilesByOthersAreWhatTheyAre) {
  struct Known {
    fs::path file;
    std::size_t triangles, open_edges;
    double volume_m3;
  };
  const std::vector<Known> known{
      {kModels / "OFF/Cube.off", 12, 0, 1},
      {kModels / "PLY/cube_binary.ply", 12, 0, 1},
      {kModels / "OBJ/box.obj", 12, 0, 1},
      {kModels / "glTF2/BoxTextured-glTF-Binary/BoxTextured.glb", 12, 0, 1},
      {kModels / "STL/sphereWithHole.stl", 285, 9, 0},
      {kModels / "STL/Wuson.stl", 3732, 393, 0},
      {kSimbody / "BricardMechanism/geometry/Bricard_ODD_PART.obj", 16, 0, 0.02},
      {kSimbody / "TaskSpaceControl-UR10/geometry/Forearm.obj", 2436, 0, 0.00854965},
      {kSimbody / "TaskSpaceControl-Atlas/geometry/l_uglut.stl", 48, 0, 0.00016477},
  };
  std::size_t seen = 0;
  for (const Known& k : known) {
    if (!fs::exists(k.file)) continue;
    ++seen;
    const auto mesh = read_mesh(k.file, {});
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh.value().triangles.size(), k.triangles) << k.file;
    EXPECT_EQ(check_closed(mesh.value()).open_edges, k.open_edges) << k.file;
    const auto mass = mesh_mass_properties(mesh.value());
    EXPECT_EQ(mass.ok(), k.open_edges == 0) << k.file;
    if (mass.ok()) {
      EXPECT_NEAR(mass.value().volume_m3, k.volume_m3, 1e-5 * k.volume_m3) << k.file;
    }
  }
  if (seen == 0) GTEST_SKIP() << "assimp-testmodels and libsimbody-dev are not installed";
}

TEST_F(MeshFile, BrokenFilesByOthersAreRefused) {
  std::size_t seen = 0;
  for (const char* name :
       {"OFF/invalid.off", "invalid/OutOfMemory.off", "invalid/empty.off", "invalid/empty.obj", "invalid/empty.ply",
        "invalid/malformed.obj", "PLY/points.ply", "PLY/pond.0.ply",
        "glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", "glTF2/IndexOutOfRange/AllIndicesOutOfRange.gltf",
        "glTF2/MissingBin/BoxTextured.gltf", "glTF2/RecursiveNodes/RecursiveNodes.gltf",
        "glTF2/SchemaFailures/sceneWrongType.gltf", "glTF2/wrongTypes/badArray.gltf", "OBJ/point_cloud.obj"}) {
    const fs::path file = kModels / name;
    if (!fs::exists(file)) continue;
    ++seen;
    EXPECT_NE(refusal(file), "not refused") << file;
  }
  if (seen == 0) GTEST_SKIP() << "assimp-testmodels is not installed";
}

TEST_F(MeshFile, NoModelByOthersBreaksTheReader) {
  if (!fs::exists(kModels)) GTEST_SKIP() << "assimp-testmodels is not installed";
  std::size_t read = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kModels)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".obj" && extension != ".stl" && extension != ".STL" && extension != ".ply" &&
        extension != ".off" && extension != ".gltf" && extension != ".glb") {
      continue;
    }
    if (fs::file_size(entry.path()) > 1000000) continue;
    const auto mesh = read_mesh(entry.path(), {});
    if (!mesh.ok()) continue;
    ++read;
    for (const auto& t : mesh.value().triangles) {
      for (const std::uint32_t v : t) ASSERT_LT(v, mesh.value().vertices_m.size()) << entry.path();
    }
    for (const Vec3& v : mesh.value().vertices_m) ASSERT_TRUE(v.allFinite()) << entry.path();
  }
  EXPECT_GT(read, 0U);
}

}  // namespace
}  // namespace poise
