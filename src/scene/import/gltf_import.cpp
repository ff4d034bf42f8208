// SPDX-License-Identifier: MIT
#include "scene/import/gltf_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "assets/files/text_file.h"
#include "assets/mesh/gltf_nodes.h"
#include "assets/tree/tree_files.h"

namespace poise::io {
namespace {

constexpr std::uint64_t kMostGltfBytes = 1ULL << 30U;
/// Vertices that are placed to find the lowest one.
constexpr double kMostPlacedVertices = 2e8;
constexpr double kMostGltfNumber = 1e9;

/// z upward instead of y.
Vec3 upright(const Vec3& v) { return {v.x(), -v.z(), v.y()}; }
Quat upright_turn() { return {std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2, 0, 0}; }

/// A rotation, and what is done to the mesh before it.
struct SplitTransform {
  Quat rotation = Quat::Identity();
  Mat3 linear = Mat3::Identity();
};

/// Relative; chosen: of matrices with five decimals.
constexpr double kSameScale = 3e-5;
double five_digits(double length) {
  double rounded = length;
  return geometry::read_number(fmt::format("{:.5g}", length), rounded) ? rounded : length;
}

/// Scales along the mesh's axes are split off, a mirror as one of them; a sheared transform goes into the mesh as it
/// is.
SplitTransform split(const Mat3& whole) {
  const Vec3 lengths = whole.colwise().norm();
  Mat3 axes = whole;
  for (int i = 0; i < 3; ++i) axes.col(i) /= lengths[i];
  // Matrices are often written with five decimals.
  const bool sheared = (axes.transpose() * axes - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-4;
  if (sheared) return {Quat::Identity(), whole};
  // Rotations and matrices are often of single precision: equal scales are to make one mesh.
  Vec3 scale = lengths;
  if ((scale.array() - scale.mean()).abs().maxCoeff() <= kSameScale * scale.mean()) scale.setConstant(scale.mean());
  for (double& along : scale) along = five_digits(along);
  if (axes.determinant() < 0) {
    axes.col(0) = -axes.col(0);
    scale.x() = -scale.x();
  }
  return {Quat(axes).normalized(), scale.asDiagonal()};
}

Result<double> lowest_point(const geometry::GltfNodes& nodes) {
  double placed = 0;
  for (const geometry::GltfNode& node : nodes.nodes)
    placed += 3 * static_cast<double>(nodes.meshes[node.mesh].triangles.size());
  if (placed > kMostPlacedVertices)
    return bad_input(fmt::format("--floor: {:.0f} vertices are placed, at most {:.0f}", placed, kMostPlacedVertices));
  double lowest = std::numeric_limits<double>::infinity();
  // Not all vertices of an accessor need be corners.
  for (const geometry::GltfNode& node : nodes.nodes) {
    const TriangleMesh& mesh = nodes.meshes[node.mesh];
    for (const auto& corners : mesh.triangles)
      for (const std::uint32_t corner : corners)
        lowest = std::min(lowest, (node.transform * mesh.vertices_m[corner].homogeneous()).y());
  }
  return lowest;
}

/// Adds the bodies. Each mesh with each linear part is a mesh of the draft; the nodes lose theirs to it.
Status add_gltf_bodies(geometry::GltfNodes& nodes, const GltfImportSettings& settings, SceneDraft& draft) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (TriangleMesh& mesh : nodes.meshes) meshes.push_back(std::make_shared<const TriangleMesh>(std::move(mesh)));
  std::map<std::pair<std::size_t, std::array<double, 9>>, std::size_t> sized;
  for (const geometry::GltfNode& node : nodes.nodes) {
    const Mat3 whole = node.transform.topLeftCorner<3, 3>();
    const Vec3 moved = node.transform.topRightCorner<3, 1>();
    const bool sound = whole.allFinite() && moved.allFinite() && moved.cwiseAbs().maxCoeff() <= kMostGltfNumber &&
                       whole.cwiseAbs().maxCoeff() <= kMostGltfNumber && whole.colwise().norm().minCoeff() >= 1e-9;
    if (!sound)
      return bad_input(fmt::format("node '{}': its transform must be finite, within {} and without a scale of 0",
                                   node.name, kMostGltfNumber));
    const SplitTransform parts = split(whole);
    std::array<double, 9> key{};
    std::copy_n(parts.linear.data(), 9, key.begin());
    const auto [found, added] = sized.try_emplace({node.mesh, key}, draft.meshes.size());
    if (added) draft.meshes.push_back({node.name, {}, meshes[node.mesh], parts.linear});
    DraftBody body;
    body.name = node.name;
    body.dynamic = !settings.all_fixed && std::ranges::find(settings.fixed, node.name) == settings.fixed.end();
    body.friction = settings.friction;
    body.position_m = upright(moved);
    body.orientation = (upright_turn() * parts.rotation).normalized();
    DraftSolid solid;
    solid.kind = SolidKind::Mesh;
    solid.mesh = found->second;
    body.solids.push_back(solid);
    draft.bodies.push_back(std::move(body));
  }
  return Done{};
}

}  // namespace

Result<SceneDraft> gltf_draft(geometry::GltfNodes nodes, const GltfImportSettings& settings) {
  for (geometry::GltfNode& node : nodes.nodes) node.transform.topRows<3>() *= settings.scale;
  for (const std::string& name : settings.fixed) {
    if (std::ranges::find(nodes.nodes, name, &geometry::GltfNode::name) == nodes.nodes.end())
      return bad_input(fmt::format("--static = '{}', must be the name of a node with a mesh", name));
  }
  SceneDraft draft;
  std::optional<double> lowest_m;
  if (settings.floor) {
    const Result<double> lowest = lowest_point(nodes);
    if (!lowest) return lowest.error();
    lowest_m = lowest.value();
  }
  const Status added = add_gltf_bodies(nodes, settings, draft);
  if (!added) return added.error();
  if (lowest_m && !draft.bodies.empty()) {
    DraftBody floor;
    floor.name = "floor";
    floor.position_m = {0, 0, *lowest_m};
    floor.friction = settings.friction;
    draft.bodies.push_back(std::move(floor));
  }
  return draft;
}

Result<SceneDraft> import_gltf(const std::filesystem::path& file, const GltfImportSettings& settings) {
  const auto refused = [&](const Error& error) { return bad_input(file.string() + ": " + error.message); };
  const Result<std::string> bytes = geometry::read_text_file(file, kMostGltfBytes);
  if (!bytes) return bytes.error();
  Result<geometry::GltfNodes> nodes = geometry::parse_gltf_nodes(bytes.value(), file.parent_path());
  if (!nodes) return refused(nodes.error());
  Result<SceneDraft> draft = gltf_draft(std::move(nodes).value(), settings);
  if (!draft) return refused(draft.error());
  draft.value().name = file.stem().string();
  return draft;
}

}  // namespace poise::io
