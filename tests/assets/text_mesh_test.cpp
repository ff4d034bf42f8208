// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "assets/files/atomic_file.h"
#include "assets/mesh/mesh_files.h"
#include "poise/assets/mesh_file.h"
#include "poise/mesh.h"
#include "scene/temporary_folder.h"

// The forms in which texts come: comments, line ends and marks of byte order. Most are told by the volume of a
// tetrahedron, since a line that is lost gives a mesh of another shape and no message.
namespace poise {
namespace {

using geometry::parse_obj;
using geometry::parse_off;
using geometry::parse_ply;
using geometry::parse_stl;
using testing::TemporaryFolder;

constexpr const char* kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
constexpr const char* kOff = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
constexpr const char* kPly =
    "ply\nformat ascii 1.0\ncomment of no use\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::string stl() {
  std::string text = "solid a name\n";
  constexpr std::array<std::array<const char*, 3>, 4> kFaces{{{"0 0 0", "0 1 0", "1 0 0"},
                                                              {"0 0 0", "1 0 0", "0 0 1"},
                                                              {"0 0 0", "0 0 1", "0 1 0"},
                                                              {"1 0 0", "0 1 0", "0 0 1"}}};
  for (const auto& face : kFaces)
    text += fmt::format("facet normal 0 0 0\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n", face[0],
                        face[1], face[2]);
  return text + "endsolid a name\n";
}

/// The volume that the triangles enclose, with its sign; NaN for a refusal, whose message the test shows.
double volume_m3(const Result<TriangleMesh>& mesh) {
  if (!mesh.ok()) {
    ADD_FAILURE() << mesh.error().message;
    return std::nan("");
  }
  double six_volumes = 0;
  for (const auto& t : mesh.value().triangles) {
    const Vec3& b = mesh.value().vertices_m[t[1]];
    six_volumes += mesh.value().vertices_m[t[0]].dot(b.cross(mesh.value().vertices_m[t[2]]));
  }
  return six_volumes / 6;
}

std::string with_line_ends(std::string text, const std::string& line_end) {
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + line_end.size()))
    text.replace(at, 1, line_end);
  return text;
}

TEST(TextMesh, ACommentThatEndsInABackslashDoesNotSwallowTheNextLine) {
  for (const char* line_end : {"\n", "\r\n", "\r"}) {
    SCOPED_TRACE(line_end[0] == '\r' ? "with carriage return" : "without");
    std::string text = kObj;
    // Without the vertex that follows, faces would be of the three others and one that a later line gives.
    text.insert(text.find("v 0 0 1"), "# drawn in C:\\models\\\n");
    text.insert(text.find("f 2 3 4"), "  # the last \\ of them\\\n");
    EXPECT_NEAR(volume_m3(parse_obj(with_line_ends(text, line_end))), 1.0 / 6, 1e-15);
    // A line that goes on may end in such a comment.
    text.replace(text.find("f 2 3 4"), 7, "f 2 \\\n3 4 # \\");
    EXPECT_NEAR(volume_m3(parse_obj(with_line_ends(text, line_end))), 1.0 / 6, 1e-15);
  }
  const Result<TriangleMesh> refused = parse_obj("# \\\nv 0 0 0 \\\n\nf 1 1 x\n");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message.find("line 4: "), 0U) << refused.error().message;
}

TEST(TextMesh, EveryLineEndGivesTheSameVolume) {
  for (const char* line_end : {"\n", "\r\n", "\r"}) {
    SCOPED_TRACE(fmt::format("{} characters, {}", std::strlen(line_end), static_cast<int>(line_end[0])));
    EXPECT_NEAR(volume_m3(parse_obj(with_line_ends(kObj, line_end))), 1.0 / 6, 1e-15);
    EXPECT_NEAR(volume_m3(parse_off(with_line_ends(kOff, line_end))), 1.0 / 6, 1e-15);
    EXPECT_NEAR(volume_m3(parse_ply(with_line_ends(kPly, line_end))), 1.0 / 6, 1e-15);
    EXPECT_NEAR(volume_m3(parse_stl(with_line_ends(stl(), line_end))), 1.0 / 6, 1e-15);
  }
}

TEST(TextMesh, AMessageCountsLinesThatEndInCarriageReturns) {
  const Result<TriangleMesh> obj = parse_obj("v 0 0 0\rv 1 x 0\r");
  ASSERT_FALSE(obj.ok());
  EXPECT_EQ(obj.error().message, "line 2: y of a vertex is 'x', must be a finite number");
}

TEST(TextMesh, ABinaryPlyMayHaveAHeaderOfCarriageReturns) {
  std::string ply = with_line_ends(
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\nproperty char z\n"
      "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n",
      "\r");
  ply += std::string("\x0a\x00\x00\x00\x0d\x00\x00\x00\x0a\x03\x00\x01\x02", 13);
  const Result<TriangleMesh> mesh = parse_ply(ply);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().vertices_m[0], Vec3(10, 0, 0));
  EXPECT_EQ(mesh.value().vertices_m[1], Vec3(0, 13, 0));
  EXPECT_EQ(mesh.value().triangles.size(), 1U);
}

TEST(TextMesh, AByteOrderMarkBeforeTextOfAnyFormatIsLeftOut) {
  const TemporaryFolder folder;
  const std::string mark = "\xef\xbb\xbf";
  const std::array<std::pair<const char*, std::string>, 4> files{
      {{"a.obj", kObj}, {"a.off", kOff}, {"a.ply", kPly}, {"a.stl", stl()}}};
  for (const auto& [name, text] : files) {
    ASSERT_TRUE(geometry::write_file(folder.file(name), mark + text).ok());
    EXPECT_NEAR(volume_m3(read_mesh(folder.file(name), {})), 1.0 / 6, 1e-12) << name;
  }
}

TEST(TextMesh, ABinaryStlWhoseHeadBeginsWithThoseBytesIsBinary) {
  std::string whole = "\xef\xbb\xbfsolid";
  whole.resize(80, ' ');
  whole += std::string("\1\0\0\0", 4) + std::string(50, '\0');
  const Result<TriangleMesh> mesh = parse_stl(whole);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().triangles.size(), 1U);
}

TEST(TextMesh, ByteNumbersOfABinaryPlyCountItsMark) {
  const std::string head =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
  for (const std::string& mark : {std::string(), std::string("\xef\xbb\xbf")}) {
    const Result<TriangleMesh> mesh = parse_ply(mark + head + std::string(8, '\0') + "\xff\xff\xff\xff\3");
    ASSERT_FALSE(mesh.ok());
    EXPECT_EQ(mesh.error().message.find(fmt::format("byte {}: entry 0", mark.size() + head.size())), 0U)
        << mesh.error().message;
  }
}

TEST(TextMesh, AMessageCountsVerticesAndLinesAsTheFileDoes) {
  const auto message = [](const Result<TriangleMesh>& mesh) { return mesh.ok() ? "read" : mesh.error().message; };
  EXPECT_EQ(message(parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n")),
            "line 4: a face names vertex 4 of 3, counted from 1, must exist");
  EXPECT_EQ(message(parse_off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n")),
            "line 6: face 0: a face names vertex 3 of 3, counted from 0, must exist");
  EXPECT_EQ(message(parse_off("OFF\n# counts\n900 1 0\n0 0 0\n")),
            "line 3: announces 900 vertices in 6 bytes, must have room for them");
  EXPECT_EQ(message(parse_off("OFF\n1 900 0\n0 0 0\n3 0 0 0\n")),
            "line 3: announces 900 faces in 8 bytes, must have room for them");
}

TEST(TextMesh, DataInAUriMayBeWrittenWithPercentSigns) {
  const auto gltf = [](const std::string& digits) {
    return R"({"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
           R"("accessors":[{"bufferView":0,"componentType":5120,"count":3,"type":"VEC3"}],)"
           R"("bufferViews":[{"buffer":0,"byteLength":9}],"buffers":[{"byteLength":9,"uri":"data:;base64,)" +
           digits + "\"}]}";
  };
  // 8 bytes and one: -5 is 0xfb, whose first digits are `+` and, in the middle of three bytes, `/`.
  const Result<TriangleMesh> plain = geometry::parse_gltf(gltf("+/v7AAEAAgAD"), ".");
  ASSERT_TRUE(plain.ok()) << plain.error().message;
  EXPECT_EQ(plain.value().vertices_m[0], Vec3(-5, -5, -5));
  const Result<TriangleMesh> encoded = geometry::parse_gltf(gltf("%2B%2fv7AAEAAgAD%3D%3d"), ".");
  ASSERT_TRUE(encoded.ok()) << encoded.error().message;
  EXPECT_EQ(encoded.value().vertices_m, plain.value().vertices_m);
  const Result<TriangleMesh> broken = geometry::parse_gltf(gltf("%2Bfv7AAEAAgA%"), ".");
  ASSERT_FALSE(broken.ok());
  EXPECT_NE(broken.error().message.find("digit 11 of a uri's data is none of base64"), std::string::npos)
      << broken.error().message;
}

}  // namespace
}  // namespace poise
