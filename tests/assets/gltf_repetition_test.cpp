// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "assets/files/atomic_file.h"
#include "assets/mesh/gltf_document.h"
#include "assets/mesh/mesh_files.h"
#include "poise/mesh.h"
#include "scene/temporary_folder.h"

// A glTF file of N bytes can name what takes N steps to read N times. What is repeated is counted, and the count bounds
// the time: no test here looks at a clock (docs/reliability.md).
namespace poise {
namespace {

using geometry::parse_gltf;
using testing::TemporaryFolder;

std::string repeated(const std::string& part, std::size_t times) {
  std::string text;
  for (std::size_t i = 0; i < times; ++i) text += (i == 0 ? "" : ",") + part;
  return text;
}

/// A file of `nodes` nodes that all place the one mesh of these primitives.
std::string placed(std::size_t nodes, const std::string& primitives, const std::string& accessors,
                   const std::string& views = R"({"buffer":0,"byteLength":36})",
                   const std::string& buffer = R"("byteLength":36,"uri":"data:;base64,)" + std::string(48, 'A') + '"') {
  std::string all;
  for (std::size_t i = 0; i < nodes; ++i) all += (i == 0 ? "" : ",") + std::to_string(i);
  return fmt::format(
      R"({{"scenes":[{{"nodes":[{}]}}],"nodes":[{}],"meshes":[{{"primitives":[{}]}}],"accessors":[{}],"bufferViews":[{}],)"
      R"("buffers":[{{{}}}]}})",
      all, repeated(R"({"mesh":0})", nodes), primitives, accessors, views, buffer);
}

constexpr const char* kTriangle = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
constexpr const char* kPlain = R"({"attributes":{"POSITION":0}})";

/// Refused for the count, long before all of it was read: the count that the message names is the limit and one step.
void expect_counted(const std::string& text, std::uint64_t one_step) {
  const Result<TriangleMesh> mesh = parse_gltf(text, ".");
  ASSERT_FALSE(mesh.ok()) << mesh.value().vertices_m.size();
  const std::string& message = mesh.error().message;
  const std::size_t at = message.find("repeat so much that ");
  ASSERT_NE(at, std::string::npos) << message;
  const std::uint64_t counted = std::stoull(message.substr(at + 20));
  EXPECT_GT(counted, geometry::kMostRepeatedNumbers + text.size());
  EXPECT_LE(counted, geometry::kMostRepeatedNumbers + text.size() + one_step) << message;
  EXPECT_NE(message.find(fmt::format("must be at most {} with the {} bytes that were read",
                                     geometry::kMostRepeatedNumbers + text.size(), text.size())),
            std::string::npos)
      << message;
}

TEST(GltfRepetition, OfPrimitivesWithoutPointsIsCounted) {
  expect_counted(placed(2000, repeated("{}", 2000), ""), 2001);
}

TEST(GltfRepetition, OfAMeshWithoutPrimitivesIsCountedWithItsMembers) {
  std::string mesh = "]";
  for (int i = 0; i < 3000; ++i) mesh += fmt::format(",\"m{}\":0", i);
  // The list of primitives ends early, and the members of the mesh follow it.
  const std::string text = placed(3000, mesh + ",\"rest\":[", "");
  expect_counted(text, 3003);
}

TEST(GltfRepetition, OfSparseValuesIsCounted) {
  const std::string sparse =
      R"({"componentType":5126,"count":1,"type":"VEC3","sparse":{"count":30000,"indices":{"bufferView":0,)"
      R"("componentType":5121},"values":{"bufferView":0,"byteOffset":30000}}})";
  const std::string buffer = R"("byteLength":390000,"uri":"data:;base64,)" + std::string(520'000, 'A') + '"';
  const std::string view = R"({"buffer":0,"byteLength":390000})";
  EXPECT_TRUE(parse_gltf(placed(10, kPlain, sparse, view, buffer), ".").ok());
  expect_counted(placed(100, kPlain, sparse, view, buffer), 3 * 30001);
}

TEST(GltfRepetition, OfAnAccessorOrAViewWithManyMembersIsCounted) {
  std::string members;
  for (int i = 0; i < 50'000; ++i) members += fmt::format("\"{}\":0,", i);
  const std::string accessor = "{" + members + std::string(kTriangle).substr(1);
  expect_counted(placed(1000, kPlain, accessor), 50'010);
  const std::string view = "{" + members + R"("buffer":0,"byteLength":36})";
  expect_counted(placed(1000, kPlain, kTriangle, view), 50'010);
}

TEST(GltfRepetition, OfALongNameIsCounted) {
  const std::string name(100'000, 'a');
  std::string all = R"("n0")";
  std::string nodes = R"("n0":{"meshes":["m"]})";
  for (int i = 1; i < 1000; ++i) {
    all += fmt::format(",\"n{}\"", i);
    nodes += fmt::format(R"(,"n{}":{{"meshes":["m"]}})", i);
  }
  expect_counted(fmt::format(R"({{"scenes":{{"s":{{"nodes":[{}]}}}},"nodes":{{{}}},"meshes":{{"m":{{"primitives":[{{)"
                             R"("attributes":{{"POSITION":"{}"}}}}]}}}},"accessors":{{"{}":{{"bufferView":"v",)"
                             R"("componentType":5126,"count":3,"type":"VEC3"}}}},"bufferViews":{{"v":{{"buffer":"b",)"
                             R"("byteLength":36}}}},"buffers":{{"b":{{"byteLength":36,"uri":"data:;base64,{}"}}}}}})",
                             all, nodes, name, name, std::string(48, 'A')),
                 100'001);
}

TEST(GltfRepetition, OfASmallMeshByManyNodesIsRead) {
  const Result<TriangleMesh> mesh = parse_gltf(placed(20'000, kPlain, kTriangle), ".");
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().triangles.size(), 20'000U);
}

// The folder changes while the file is read: whoever looks for the buffer again finds another one.
TEST(GltfRepetition, DoesNotLookForABufferTwice) {
  const TemporaryFolder folder;
  ASSERT_TRUE(geometry::write_file(folder.file("one.bin"), std::string(36, '\0')).ok());
  ASSERT_TRUE(geometry::write_file(folder.file("two.bin"), std::string(36, '\x40')).ok());
  std::filesystem::create_symlink(folder.file("one.bin"), folder.file("link.bin"));
  const std::string text =
      placed(1, kPlain, kTriangle, R"({"buffer":0,"byteLength":36})", R"("byteLength":36,"uri":"link.bin")");
  Result<geometry::GltfDocument> document = geometry::GltfDocument::open(text, folder.path());
  ASSERT_TRUE(document.ok()) << document.error().message;
  const io::JsonValue& primitive =
      document.value().entries(geometry::GltfList::Meshes)[0].find("primitives")->items()[0];
  const io::JsonValue& accessor = *primitive.find("attributes")->find("POSITION");
  std::vector<Vec3> points;
  ASSERT_TRUE(document.value().add_points(accessor, points).ok());
  std::filesystem::remove(folder.file("link.bin"));
  std::filesystem::create_symlink(folder.file("two.bin"), folder.file("link.bin"));
  ASSERT_TRUE(document.value().add_points(accessor, points).ok());
  ASSERT_EQ(points.size(), 6U);
  EXPECT_EQ(points[3], Vec3::Zero());
}

}  // namespace
}  // namespace poise
