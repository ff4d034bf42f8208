// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

#include "collision/instruction_sets.h"
#include "geometry/mesh/bumpy_ball.h"
#include "geometry/mesh/procedural.h"
#include "poise/sphere_tree.h"

/// The bits of meshes made by the library and of sphere trees built from them, from no cache. A changed hash means
/// other trees, so other motion, and the commit that changes it must give the reason.
namespace poise {
namespace {

/// FNV-1a (Fowler, Noll and Vo 1991) of the values' bytes, the lowest first.
class Hash {
 public:
  template <class Value>
  void add(const std::vector<Value>& values) {
    for (const Value& value : values) add_value(value);
  }
  void add_value(const Vec3& v) {
    for (const double x : {v.x(), v.y(), v.z()}) add_value(x);
  }
  void add_value(const std::array<std::uint32_t, 3>& triangle) {
    for (const std::uint32_t x : triangle) add_value(x);
  }
  void add_value(const NodeFit& fit) {
    for (const float x : {fit.x_m, fit.y_m, fit.z_m, fit.radius_m, fit.variance_m2, fit.core_m}) add_value(x);
  }
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void add_value(Number number) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &number, sizeof(number));
    for (std::size_t byte = 0; byte < sizeof(number); ++byte)
      hash_ = (hash_ ^ (bits >> (8 * byte) & 0xff)) * 0x100000001b3ULL;
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

std::uint64_t hash_of(const TriangleMesh& mesh) {
  Hash hash;
  hash.add(mesh.vertices_m);
  hash.add(mesh.triangles);
  return hash.value();
}

std::uint64_t hash_of(const SphereTree& tree) {
  Hash hash;
  hash.add(tree.x_m);
  hash.add(tree.y_m);
  hash.add(tree.z_m);
  hash.add(tree.radius_m);
  hash.add(tree.protrusion_max_m);
  hash.add(tree.protrusion_mean_m);
  hash.add(tree.fit);
  hash.add(tree.first_child);
  hash.add(tree.child_count);
  hash.add(tree.level_begin);
  return hash.value();
}

struct GoldenShape {
  const char* name;
  std::uint64_t mesh = 0;
  std::uint64_t fast_tree = 0;     // of depth 2
  std::uint64_t default_tree = 0;  // of depth 1
};

void PrintTo(const GoldenShape& golden, std::ostream* out) { *out << golden.name; }

const std::vector<GoldenShape> kShapes = {
#include "golden/shape_hashes.inc"
};

TriangleMesh mesh_of(const GoldenShape& golden) {
  const std::string name = golden.name;
  if (name == "bumpy") return geometry::bumpy_ball(2000).value();
  return geometry::make_procedural_shape(name).value();
}

std::uint64_t tree_hash(const TriangleMesh& mesh, TreePreset preset, Level depth) {
  return hash_of(build_sphere_tree(mesh, {.depth = depth, .preset = preset, .threads = 2}).value());
}

class ShapeHash : public testing::TestWithParam<GoldenShape> {};

TEST_P(ShapeHash, OfMeshAndTreesStaysAsItWas) {
  const GoldenShape& golden = GetParam();
  const TriangleMesh mesh = mesh_of(golden);
  const std::uint64_t of_mesh = hash_of(mesh);
  const std::uint64_t fast = tree_hash(mesh, TreePreset::Fast, 2);
  const std::uint64_t thorough = tree_hash(mesh, TreePreset::Default, 1);
  EXPECT_TRUE(of_mesh == golden.mesh && fast == golden.fast_tree && thorough == golden.default_tree)
      << fmt::format("{{\"{}\", 0x{:016x}ULL, 0x{:016x}ULL, 0x{:016x}ULL}},", golden.name, of_mesh, fast, thorough);
}

INSTANTIATE_TEST_SUITE_P(OfShapes, ShapeHash, testing::ValuesIn(kShapes),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(ShapeHashOfKernels, OfATreeIsTheSameOnEveryInstructionSet) {
  const GoldenShape& golden = kShapes.front();
  const TriangleMesh mesh = mesh_of(golden);
  const int sets = collision::on_every_instruction_set(
      [&](const char* name) { EXPECT_EQ(tree_hash(mesh, TreePreset::Fast, 2), golden.fast_tree) << name; });
  EXPECT_GE(sets, 2);
}

}  // namespace
}  // namespace poise
