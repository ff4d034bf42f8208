// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "assets/mesh/mesh_files.h"
#include "poise/mesh.h"

// Files that broke, stopped or misled the readers of others that were used before, built here (docs/reliability.md).
namespace poise {
namespace {

using geometry::parse_gltf;
using geometry::parse_obj;
using geometry::parse_off;
using geometry::parse_ply;
using geometry::parse_stl;

std::string refusal(const Result<TriangleMesh>& mesh) {
  return mesh.ok() ? fmt::format("read: {} triangles", mesh.value().triangles.size()) : mesh.error().message;
}

void expect_refused(const Result<TriangleMesh>& mesh, const std::string& part) {
  EXPECT_NE(refusal(mesh).find(part), std::string::npos) << refusal(mesh);
}

/// A prism as `vertex` and `face` write its lines; its two ends are polygons of `sides` corners.
template <class Vertex, class Face>
std::string prism(std::uint32_t sides, Vertex&& vertex, Face&& face) {
  std::string text;
  for (std::uint32_t i = 0; i < 2 * sides; ++i) {
    const double angle = 2 * 3.141592653589793 * (i % sides) / sides;
    text += vertex(std::cos(angle), std::sin(angle), i < sides ? 0 : 1);
  }
  std::vector<std::uint32_t> bottom, top;
  for (std::uint32_t i = 0; i < sides; ++i) {
    bottom.push_back(sides - 1 - i);
    top.push_back(sides + i);
    text += face(std::vector<std::uint32_t>{i, (i + 1) % sides, sides + (i + 1) % sides, sides + i});
  }
  return text + face(bottom) + face(top);
}

std::string coordinates(double x, double y, double z) { return fmt::format("{} {} {}\n", x, y, z); }

std::string counted_face(const std::vector<std::uint32_t>& corners) {
  return fmt::format("{} {}\n", corners.size(), fmt::join(corners, " "));
}

void expect_closed_prism(const Result<TriangleMesh>& mesh, std::uint32_t sides) {
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().triangles.size(), 4 * sides - 4);
  EXPECT_EQ(check_closed(mesh.value()).open_edges, 0U);
  const double area = 0.5 * sides * std::sin(2 * 3.141592653589793 / sides);
  EXPECT_NEAR(mesh_mass_properties(mesh.value()).value().volume_m3, area, 1e-12);
}

TEST(HostileObj, AFaceOfMoreThan255CornersIsReadWhole) {
  for (const std::uint32_t sides : {255U, 256U, 700U}) {
    const std::string text = prism(
        sides, [](double x, double y, double z) { return "v " + coordinates(x, y, z); },
        [](std::vector<std::uint32_t> corners) {
          for (std::uint32_t& corner : corners) ++corner;
          return fmt::format("f {}\n", fmt::join(corners, " "));
        });
    expect_closed_prism(parse_obj(text), sides);
  }
}

TEST(HostileOff, AFaceOfTenAndMoreCornersIsReadWhole) {
  for (const std::uint32_t sides : {9U, 10U, 12U, 300U})
    expect_closed_prism(
        parse_off(fmt::format("OFF\n{} {} 0\n", 2 * sides, sides + 2) + prism(sides, coordinates, counted_face)),
        sides);
}

constexpr const char* kPlyHead =
    "ply\nformat ascii 1.0\nelement vertex 24\nproperty float x\nproperty float y\nproperty float z\nelement face 14\n"
    "property list uchar int vertex_indices\nend_header\n";

TEST(HostileText, AFileCutWithinItsFacesIsNoOpenMesh) {
  const std::string entries = prism(12, coordinates, counted_face);
  const std::string off = "OFF\n24 14 0\n" + entries;
  const std::string ply = kPlyHead + entries;
  ASSERT_TRUE(parse_off(off).ok());
  ASSERT_TRUE(parse_ply(ply).ok()) << refusal(parse_ply(ply));
  // Without its last digit, the last face names another vertex that is there.
  for (std::size_t cut = 3; cut < entries.size(); ++cut) {
    EXPECT_FALSE(parse_off(off.substr(0, off.size() - cut)).ok()) << cut;
    EXPECT_FALSE(parse_ply(ply.substr(0, ply.size() - cut)).ok()) << cut;
  }
  expect_refused(parse_off(off.substr(0, off.size() - 60)), "line 39: face 12: announces 12 corners in 6 bytes");
  expect_refused(parse_ply(ply.substr(0, ply.size() - 60)), "line 46: entry 12 of 14 of 'face': ");
}

TEST(HostileText, AnObjCutBetweenItsFacesIsReadAsAnOpenMesh) {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  EXPECT_EQ(check_closed(parse_obj(obj).value()).open_edges, 0U);
  for (std::size_t size = obj.find('f'); size < obj.size() - 1; ++size) {
    const Result<TriangleMesh> mesh = parse_obj(obj.substr(0, size));
    const bool between = obj[size - 1] == '\n' || obj[size] == '\n';
    EXPECT_EQ(mesh.ok(), between) << size;
    if (mesh.ok() && !mesh.value().triangles.empty()) {
      EXPECT_GT(check_closed(mesh.value()).open_edges, 0U) << size;
    }
  }
}

template <class Number>
void put(std::string& bytes, Number value, bool big_end_first) {
  std::array<char, sizeof(Number)> raw{};
  std::memcpy(raw.data(), &value, raw.size());
  if (big_end_first) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

std::string binary_ply(bool big_end_first) {
  std::string ply = fmt::format(
      "ply\nformat binary_{}_endian 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty short z\n"
      "property list uchar short other\nelement face 1\nproperty uchar red\nproperty list ushort uint vertex_index\n"
      "end_header\n",
      big_end_first ? "big" : "little");
  for (int i = 0; i < 3; ++i) {
    put(ply, i == 1 ? 0.1 : 0.0, big_end_first);
    put(ply, i == 2 ? 2.5F : 0.0F, big_end_first);
    put(ply, static_cast<std::int16_t>(-3), big_end_first);
    ply += '\2';
    for (int k = 0; k < 2; ++k) put(ply, static_cast<std::int16_t>(k), big_end_first);
  }
  ply += '\7';
  put(ply, static_cast<std::uint16_t>(3), big_end_first);
  for (std::uint32_t i = 0; i < 3; ++i) put(ply, i, big_end_first);
  return ply;
}

TEST(HostilePly, EveryTypeIsReadInBothOrdersOfBytesAndNoCutFileIs) {
  for (const bool big_end_first : {false, true}) {
    const std::string ply = binary_ply(big_end_first);
    const Result<TriangleMesh> mesh = parse_ply(ply);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh.value().vertices_m[1], Vec3(0.1, 0, -3));
    EXPECT_EQ(mesh.value().vertices_m[2], Vec3(0, 2.5, -3));
    ASSERT_EQ(mesh.value().triangles.size(), 1U);
    EXPECT_EQ(mesh.value().triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
    for (std::size_t size = 0; size < ply.size(); ++size) EXPECT_FALSE(parse_ply(ply.substr(0, size)).ok()) << size;
  }
}

TEST(HostilePly, AStripIsTrianglesWithOneOrientation) {
  const Result<TriangleMesh> mesh = parse_ply(
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement "
      "tristrips "
      "1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 4 -1 2 3 4\n");
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  ASSERT_EQ(mesh.value().triangles.size(), 4U);
  for (const auto& t : mesh.value().triangles) {
    const Vec3& a = mesh.value().vertices_m[t[0]];
    EXPECT_GT((mesh.value().vertices_m[t[1]] - a).cross(mesh.value().vertices_m[t[2]] - a).z(), 0);
  }
}

TEST(HostilePly, AHeaderWithoutEndOrALengthWithoutRoomIsRefused) {
  expect_refused(parse_ply("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"), "without 'end_header'");
  expect_refused(parse_ply("ply\nformat ascii 1.0\nelement vertex 3"), "line 3: the header ends without 'end_header'");
  const std::string head =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uint int vertex_indices\nend_header\n" +
      std::string(12, '\0');
  for (const std::uint32_t length : {500'000'000U, 0xffffffffU, 20U}) {
    std::string ply = head;
    put(ply, length, false);
    ply += std::string(40, '\0');
    expect_refused(parse_ply(ply), fmt::format("the length of 'vertex_indices' = {}, must be at least 0", length));
  }
  expect_refused(
      parse_ply("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
                "z\nelement face 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n-3 0 0 0\n"),
      "line 11: entry 0 of 1 of 'face': the length of 'vertex_indices' = -3");
  expect_refused(
      parse_ply("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
                "z\nelement face 1\nproperty list int float vertex_indices\nend_header\n0 0 0\n3 0 0 0\n"),
      "has no list 'vertex_indices' of whole numbers");
}

TEST(HostileOff, WhatDoesNotExistOrHasNoRoomIsRefused) {
  const std::string head = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
  expect_refused(parse_off(head + "3 0 1 3\n"), "line 6: face 0: a face names vertex 3 of 3");
  expect_refused(parse_off(head + "3 0 1 -1\n"), "corner 2 of 3 is '-1', must be the number of a vertex");
  expect_refused(parse_off(head + "4000000000 0 1 2\n"), "announces 4000000000 corners in 6 bytes");
  expect_refused(parse_off(head + "2 0 1\n"), "a face has 2 corners, must have at least 3");
  expect_refused(parse_off("OFF BINARY\n3 1 0\n"), "the number of vertices is 'BINARY'");
  expect_refused(parse_off("4OFF\n3 1 0\n"), "the number of vertices is '4OFF'");
  expect_refused(parse_off(""), "must be a whole number");
  EXPECT_TRUE(
      parse_off("COFF 3 1 0 # counts\n\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2 0.5 0.5 0.5").ok());
}

std::string ascii_stl(std::size_t facets) {
  std::string text = "solid a name of several words\n";
  for (std::size_t i = 0; i < facets; ++i)
    text += "facet normal nan 0 0\nouter loop\nVERTEX 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  return text + "endsolid a name of several words\n";
}

TEST(HostileStl, ATextCutAnywhereIsRefused) {
  const std::string whole = ascii_stl(2);
  ASSERT_TRUE(parse_stl(whole).ok()) << refusal(parse_stl(whole));
  EXPECT_EQ(parse_stl(whole).value().triangles.size(), 2U);
  for (std::size_t size = 0; size < whole.find("endsolid") + 8; ++size)
    EXPECT_FALSE(parse_stl(whole.substr(0, size)).ok()) << size;
  expect_refused(parse_stl("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n"),
                 "line 6: 'endloop' stands where 'vertex' should");
  expect_refused(parse_stl("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 inf 0\n"),
                 "line 4: y of a vertex is 'inf'");
}

TEST(HostileStl, ABinaryFileHasTheLengthThatItsCountSays) {
  std::string whole = "solid is how some binary files begin";
  whole.resize(80, ' ');
  put(whole, std::uint32_t{2}, false);
  for (int i = 0; i < 2; ++i) {
    for (const float number : {0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) put(whole, number, false);
    whole += "ab";
  }
  ASSERT_TRUE(parse_stl(whole).ok()) << refusal(parse_stl(whole));
  EXPECT_EQ(parse_stl(whole).value().triangles.size(), 2U);
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(parse_stl(whole.substr(0, size)).ok()) << size;
  std::string other = whole;
  other.replace(0, 5, "other");
  expect_refused(parse_stl(other.substr(0, 183)), "byte 80: announces 2 triangles, must then have 184 bytes, has 183");
  other.resize(178);
  put(other, std::numeric_limits<float>::infinity(), false);
  other += "ab";
  expect_refused(parse_stl(other), "byte 178: z of corner 2 of triangle 1 is inf");
}

/// A glTF file whose buffer are these bytes; the braces of `rest` are meant.
std::string gltf(const std::string& rest, std::size_t buffer_bytes) {
  return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"buffers":[{"byteLength":)" +
         std::to_string(buffer_bytes) + R"(,"uri":"data:application/octet-stream;base64,)" +
         std::string((buffer_bytes + 2) / 3 * 4, 'A') + "\"}]," + rest + "}";
}

std::string one_mesh(const std::string& primitive, const std::string& accessors, const std::string& views) {
  return R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[)" + primitive + "]}],\"accessors\":[" + accessors +
         "],\"bufferViews\":[" + views + "]";
}

constexpr const char* kPositions = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
constexpr const char* kView = R"({"buffer":0,"byteLength":36})";

TEST(HostileGltf, LinesWithOneIndexAndStripsWithoutATriangleHaveNoSurface) {
  for (int mode = 0; mode < 7; ++mode) {
    const Result<TriangleMesh> mesh = parse_gltf(
        gltf(one_mesh(fmt::format(R"({{"attributes":{{"POSITION":0}},"indices":1,"mode":{}}})", mode),
                      std::string(kPositions) + R"(,{"bufferView":0,"componentType":5121,"count":1,"type":"SCALAR"})",
                      kView),
             36),
        ".");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_TRUE(mesh.value().triangles.empty());
  }
}

TEST(HostileGltf, AnAccessorBeyondItsViewOrBufferIsRefused) {
  const auto accessor = [](const std::string& members) {
    return parse_gltf(gltf(one_mesh(R"({"attributes":{"POSITION":0}})", "{" + members + "}", kView), 36), ".");
  };
  const std::string rule = "must lie in the 36 bytes of its view";
  EXPECT_TRUE(accessor(R"("bufferView":0,"componentType":5126,"count":3,"type":"VEC3")").ok());
  expect_refused(accessor(R"("bufferView":0,"componentType":5126,"count":4,"type":"VEC3")"), rule);
  expect_refused(accessor(R"("bufferView":0,"byteOffset":4,"componentType":5126,"count":3,"type":"VEC3")"), rule);
  expect_refused(
      accessor(R"("bufferView":0,"byteOffset":18446744073709551615,"componentType":5126,"count":3,"type":"VEC3")"),
      rule);
  expect_refused(accessor(R"("bufferView":0,"componentType":5126,"count":18446744073709551615,"type":"VEC3")"), rule);
  expect_refused(accessor(R"("bufferView":0,"byteOffset":-4,"componentType":5126,"count":3,"type":"VEC3")"), rule);
  expect_refused(
      accessor(R"("bufferView":0,"byteStride":18446744073709551615,"componentType":5126,"count":3,"type":"VEC3")"),
      rule);
  expect_refused(accessor(R"("bufferView":0,"componentType":5126,"count":0,"type":"VEC3")"),
                 "count must be a whole number from 1");
  expect_refused(accessor(R"("bufferView":0,"componentType":5124,"count":3,"type":"VEC3")"),
                 "componentType must be from 5120");
  expect_refused(accessor(R"("bufferView":9,"componentType":5126,"count":3,"type":"VEC3")"),
                 "bufferView = 9, must exist");
  expect_refused(accessor(R"("componentType":5126,"count":4000000000,"type":"VEC3")"),
                 "must be at most 1048576 without a bufferView");
}

TEST(HostileGltf, SparseValuesAreThoseOfTheFormatOrRefused) {
  const auto sparse = [](const std::string& members) {
    return parse_gltf(gltf(one_mesh(R"({"attributes":{"POSITION":0}})",
                                    R"({"componentType":5126,"count":3,"type":"VEC3","sparse":{)" + members + "}}",
                                    std::string(kView) + R"(,{"buffer":0,"byteOffset":30,"byteLength":6})"),
                           36),
                      ".");
  };
  EXPECT_TRUE(sparse(R"("count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0})").ok());
  const std::string rule = "of its view";
  expect_refused(sparse(R"("count":7,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0})"),
                 rule);
  expect_refused(sparse(R"("count":2,"indices":{"bufferView":1,"componentType":5125},"values":{"bufferView":0})"),
                 rule);
  expect_refused(
      sparse(R"("count":1,"indices":{"bufferView":1,"componentType":5121,"byteOffset":6},"values":{"bufferView":0})"),
      rule);
  expect_refused(sparse(R"("count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":1})"),
                 rule);
  expect_refused(sparse(R"("count":1,"indices":{"bufferView":1,"componentType":5126},"values":{"bufferView":0})"),
                 "sparse.indices.componentType");
  expect_refused(sparse(R"("count":1)"), "must have count, indices and values");
}

TEST(HostileGltf, NodesThatAreNoTreeAreRefusedAndADeepChainIsRead) {
  const std::string mesh = std::string(R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[)") +
                           kPositions + R"(],"bufferViews":[)" + kView + "],\"nodes\":[";
  const auto nodes = [&](const std::string& list) { return parse_gltf(gltf(mesh + list + "]", 36), "."); };
  expect_refused(nodes(R"({"children":[0]})"), "nodes[0] is its own descendant or has two parents");
  expect_refused(nodes(R"({"children":[1]},{"children":[2]},{"children":[1]})"), "nodes[1] is its own descendant");
  expect_refused(nodes(R"({"children":[1,1]},{})"), "nodes[1] is its own descendant or has two parents");
  expect_refused(nodes(R"({"children":[7]})"), "a list of nodes names 7, must exist");
  std::string chain;
  constexpr int kDepth = 100'000;
  for (int i = 1; i < kDepth; ++i) chain += fmt::format("{{\"children\":[{}]}},", i);
  const Result<TriangleMesh> deep = nodes(chain + "{\"mesh\":0}");
  ASSERT_TRUE(deep.ok()) << deep.error().message;
  EXPECT_EQ(deep.value().triangles.size(), 1U);
  expect_refused(parse_gltf(std::string(100'000, '['), "."), "nested deeper than 64 levels");
}

TEST(HostileGltf, AMeshRepeatedOutOfProportionIsRefused) {
  std::string nodes =
      R"("scene":0,"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5120,"count":30000,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":90000}],"nodes":[{"children":[1)";
  for (int i = 2; i <= 60; ++i) nodes += fmt::format(",{}", i);
  nodes += "]}";
  for (int i = 1; i <= 60; ++i) nodes += ",{\"mesh\":0}";
  expect_refused(parse_gltf(gltf(nodes + "]", 90000), "."), "its nodes, meshes and accessors repeat so much that ");
}

TEST(HostileGltf, WhatWouldBeReadWronglyIsRefusedByItsName) {
  expect_refused(
      parse_gltf(gltf(one_mesh(R"({"attributes":{"POSITION":0},"extensions":{"KHR_draco_mesh_compression":{}}})",
                               kPositions, kView),
                      36),
                 "."),
      "compressed by KHR_draco_mesh_compression");
  expect_refused(
      parse_gltf(gltf(one_mesh(R"({"attributes":{"POSITION":0}})", kPositions,
                               R"({"buffer":0,"byteLength":36,"extensions":{"EXT_meshopt_compression":{}}})"),
                      36),
                 "."),
      "compressed by EXT_meshopt_compression");
  expect_refused(parse_gltf(gltf(R"("nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{}}}])", 36), "."),
                 "has instances by EXT_mesh_gpu_instancing");
}

TEST(HostileGltf, VersionOneTurnsAboutTheNodeAndThenMoves) {
  // Half a turn about z and then 5 m along x: the reader of others moved first.
  const std::string text =
      R"({"scenes":{"s":{"nodes":["n"]}},"scene":"s","nodes":{"n":{"meshes":["m"],"translation":[5,0,0],"rotation":[0,0,1,0]}},
    "meshes":{"m":{"primitives":[{"attributes":{"POSITION":"a"}}]}},"accessors":{"a":{"bufferView":"v","byteOffset":0,"byteStride":12,"componentType":5126,"count":3,"type":"VEC3"}},
    "bufferViews":{"v":{"buffer":"b","byteLength":36}},"buffers":{"b":{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}})";
  const Result<TriangleMesh> mesh = parse_gltf(text, ".");
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_NEAR((mesh.value().vertices_m[1] - Vec3(4, 0, 0)).norm(), 0, 1e-15);
}

TEST(HostileObj, AFaceThatCannotBeCutIsRefused) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
  for (int i = 0; i < 30'000; ++i) text += " 1";
  expect_refused(parse_obj(text), "line 4: a face of 30000 corners");
  expect_refused(parse_obj("v 0 0 0\nv 1 0 0\nf 1 2\n"), "line 3: a face has 2 corners, must have at least 3");
  expect_refused(parse_obj("v 0 0 0\nf 1 x 1\n"), "line 2: a corner of a face is 'x'");
  expect_refused(parse_obj("v 0 0 0\nf 1 9223372036854775807 1\n"), "line 2: a face names vertex 9223372036854775807");
  expect_refused(parse_obj("v 0 0 0\nf 1 -9223372036854775808 1\n"),
                 "line 2: a face names vertex -9223372036854775808");
}

}  // namespace
}  // namespace poise
