// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "assets/mesh/mesh_files.h"
#include "poise/mesh.h"

// What the members of a glTF file mean, by the signed volume and the centre of what is read: a tetrahedron with an edge
// of 1 along each axis unless the case says otherwise. Nothing is repaired here, so that a wrong orientation is seen.
namespace poise {
namespace {

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string digits;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) digits += i + k < bytes.size() + 1 ? kDigits[bits >> (18 - 6 * k) & 63U] : '=';
  }
  return digits;
}

template <class Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

/// A file whose accessor 0 reads view 0, all of `points`, and whose accessor 1 reads view 1, all of `indices`.
struct File {
  std::string points = bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  std::string indices = bytes_of<std::uint16_t>({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  std::string scenes = R"([{"nodes":[0]}])";
  std::string nodes = R"([{"mesh":0}])";
  std::string primitives = R"([{"attributes":{"POSITION":0},"indices":1}])";
  std::string accessor_0 = R"("bufferView":0,"componentType":5126,"count":4,"type":"VEC3")";
  std::string accessor_1 = R"("bufferView":1,"componentType":5123,"count":12,"type":"SCALAR")";
  std::string view_0;  ///< members beside those that are always there
  std::string more;    ///< members of the file

  [[nodiscard]] std::string text() const {
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scenes":{},"nodes":{},"meshes":[{{"primitives":{}}}],"accessors":[{{{}}},{{{}}}],)"
        R"("bufferViews":[{{"buffer":0,"byteLength":{}{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],)"
        R"("buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}]{}}})",
        scenes, nodes, primitives, accessor_0, accessor_1, points.size(), view_0, points.size(), indices.size(),
        points.size() + indices.size(), base64(points + indices), more);
  }
};

struct Case {
  const char* what;
  File file;
  double volume_m3;
  Vec3 center_m = Vec3::Zero();  ///< mean of the corners of all triangles
};

File with_nodes(const std::string& nodes) {
  File file;
  file.nodes = nodes;
  return file;
}

File with_indices(const std::string& bytes, int component, std::size_t count, const std::string& primitives) {
  File file;
  file.indices = bytes;
  file.accessor_1 = fmt::format(R"("bufferView":1,"componentType":{},"count":{},"type":"SCALAR")", component, count);
  file.primitives = primitives;
  return file;
}

File with_points(const std::string& bytes, const std::string& accessor, const std::string& view = "") {
  File file;
  file.points = bytes;
  file.accessor_0 = accessor;
  file.view_0 = view;
  return file;
}

File two_scenes(const std::string& more) {
  File file = with_nodes(R"([{"mesh":0},{"mesh":0,"scale":[2,2,2]}])");
  file.scenes = R"([{"nodes":[0]},{"nodes":[1]}])";
  file.more = more;
  return file;
}

/// A pyramid of 1 m, a square of 1 m^2 wide: its sides fan out from the tip, its base from a corner.
File pyramid_of_fans() {
  File file = with_indices(bytes_of<std::uint8_t>({4, 0, 1, 2, 3, 0, 0, 3, 2, 1}), 5121, 6,
                           R"([{"attributes":{"POSITION":0},"indices":1,"mode":6},)"
                           R"({"attributes":{"POSITION":0},"indices":2,"mode":6}])");
  file.points = bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 1});
  file.accessor_0 = R"("bufferView":0,"componentType":5126,"count":5,"type":"VEC3")";
  file.accessor_1 += R"(},{"bufferView":1,"byteOffset":6,"componentType":5121,"count":4,"type":"SCALAR")";
  return file;
}

/// Points at byte 4 of every 20, with something else between them.
File interleaved() {
  std::vector<float> numbers;
  for (const std::array<float, 3> p : {std::array<float, 3>{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
    numbers.insert(numbers.end(), {7, p[0], p[1], p[2], 9});
  return with_points(bytes_of(numbers), R"("bufferView":0,"byteOffset":4,"componentType":5126,"count":4,"type":"VEC3")",
                     R"(,"byteStride":20)");
}

/// The last point, replaced by one twice as high: the index and the point lie behind the others.
File sparse(bool with_base) {
  File file;
  const std::string members =
      R"("componentType":5126,"count":4,"type":"VEC3","sparse":{"count":COUNT,"indices":{"bufferView":0,"byteOffset":48,)"
      R"("componentType":5123},"values":{"bufferView":0,"byteOffset":56}})";
  const auto filled = [&](const char* count) { return std::string(members).replace(members.find("COUNT"), 5, count); };
  if (with_base) {
    file.points += bytes_of<std::uint16_t>({3, 0, 0, 0}) + bytes_of<float>({0, 0, 2});
    file.accessor_0 = R"("bufferView":0,)" + filled("1");
  } else {
    file.points += bytes_of<std::uint16_t>({3, 1, 2, 0}) + bytes_of<float>({0, 0, 3, 1, 0, 0, 0, 1, 0});
    file.accessor_0 = filled("3");
  }
  return file;
}

std::vector<Case> cases() {
  const std::string plain = R"([{"attributes":{"POSITION":0},"indices":1}])";
  const Vec3 quarter = Vec3::Constant(0.25);
  const std::string shorts = bytes_of<std::int16_t>({-32768, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0});
  return {
      {"as it is", File{}, 1.0 / 6, quarter},
      {"indices of 8 bits", with_indices(bytes_of<std::uint8_t>({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}), 5121, 12, plain),
       1.0 / 6, quarter},
      {"indices of 32 bits",
       with_indices(bytes_of<std::uint32_t>({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}), 5125, 12, plain), 1.0 / 6, quarter},
      {"a matrix by columns: x to 2 y, y to 3 z, z to 4 x, and then moved",
       with_nodes(R"([{"mesh":0,"matrix":[0,2,0,0, 0,0,3,0, 4,0,0,0, 10,20,30,1]}])"), 4, Vec3(11, 20.5, 30.75)},
      {"a matrix that mirrors", with_nodes(R"([{"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,0,1]}])"), 1.0 / 6,
       Vec3(0.25, 0.25, -0.25)},
      {"one scale below 0", with_nodes(R"([{"mesh":0,"scale":[-2,1,1]}])"), 1.0 / 3, Vec3(-0.5, 0.25, 0.25)},
      {"two scales below 0", with_nodes(R"([{"mesh":0,"scale":[-1,-1,1]}])"), 1.0 / 6, Vec3(-0.25, -0.25, 0.25)},
      {"a mirror in a mirror", with_nodes(R"([{"children":[1],"scale":[-1,1,1]},{"mesh":0,"scale":[1,-1,1]}])"),
       1.0 / 6, Vec3(-0.25, -0.25, 0.25)},
      {"scaled, then turned a quarter about z, then moved",
       with_nodes(R"([{"mesh":0,"translation":[0,0,5],"rotation":[0,0,1,1],"scale":[3,1,1]}])"), 0.5,
       Vec3(-0.25, 0.75, 5.25)},
      {"a strip",
       with_indices(bytes_of<std::uint16_t>({0, 2, 1, 3, 0, 2}), 5123, 6,
                    R"([{"attributes":{"POSITION":0},"indices":1,"mode":5}])"),
       1.0 / 6, quarter},
      {"fans", pyramid_of_fans(), 1.0 / 3, Vec3(0.5, 0.5, 4.0 / 18)},
      {"quantized as shares of the largest, of which -32768 is no more than -1",
       with_points(shorts, R"("bufferView":0,"componentType":5122,"normalized":true,"count":4,"type":"VEC3")",
                   R"(,"byteStride":8)"),
       1.0 / 3, Vec3(0, 0.25, 0.25)},
      {"quantized as they are, scaled by the node",
       [] {
         File file =
             with_points(bytes_of<std::uint8_t>({0, 0, 0, 0, 200, 0, 0, 0, 0, 200, 0, 0, 0, 0, 200, 0}),
                         R"("bufferView":0,"componentType":5121,"count":4,"type":"VEC3")", R"(,"byteStride":4)");
         file.nodes = R"([{"mesh":0,"scale":[0.005,0.005,0.005]}])";
         return file;
       }(),
       1.0 / 6, quarter},
      {"a sparse accessor", sparse(true), 1.0 / 3, Vec3(0.25, 0.25, 0.5)},
      {"a sparse accessor of nothing", sparse(false), 0.5, Vec3(0.25, 0.25, 0.75)},
      {"20 bytes from point to point", interleaved(), 1.0 / 6, quarter},
      {"scene 1 of two", two_scenes(R"(,"scene":1)"), 8.0 / 6, Vec3::Constant(0.5)},
      {"the first scene where none is named", two_scenes(""), 1.0 / 6, quarter},
  };
}

TEST(GltfValues, GiveTheVolumeAndCentreThatTheFormatSays) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.what);
    const Result<TriangleMesh> mesh = geometry::parse_gltf(c.file.text(), ".");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    double six_volumes = 0;
    Vec3 sum = Vec3::Zero();
    for (const auto& t : mesh.value().triangles) {
      const Vec3& a = mesh.value().vertices_m[t[0]];
      const Vec3& b = mesh.value().vertices_m[t[1]];
      const Vec3& d = mesh.value().vertices_m[t[2]];
      six_volumes += a.dot(b.cross(d));
      sum += a + b + d;
    }
    EXPECT_NEAR(six_volumes / 6, c.volume_m3, 1e-6);
    const Vec3 center = sum / (3 * static_cast<double>(mesh.value().triangles.size()));
    EXPECT_NEAR((center - c.center_m).norm(), 0, 1e-6) << center.transpose();
  }
}

}  // namespace
}  // namespace poise
