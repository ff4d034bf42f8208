// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "assets/mesh/gltf_document.h"
#include "assets/mesh/gltf_nodes.h"
#include "assets/mesh/mesh_files.h"

namespace poise::geometry {
namespace {

using io::JsonValue;
using Transform = Eigen::Matrix4d;

constexpr std::uint64_t kTriangles = 4, kStrip = 5, kFan = 6;

/// Numbers of a member; false if it is something else than `count` numbers. Without the member they stay.
bool read_numbers(const JsonValue& node, const char* name, std::size_t count, double* numbers) {
  const JsonValue* value = node.find(name);
  if (value == nullptr) return true;
  if (!value->is_array() || value->items().size() != count) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (!value->items()[i].is_number()) return false;
    numbers[i] = value->items()[i].number();
  }
  return true;
}

Result<Transform> transform_of(const JsonValue& node, const std::string& place) {
  std::array<double, 16> matrix{};
  if (node.find("matrix") != nullptr) {
    if (!read_numbers(node, "matrix", matrix.size(), matrix.data()))
      return bad_input(place + ".matrix must be a list of 16 numbers");
    const Transform given(Eigen::Map<const Transform>(matrix.data()));
    if ((given.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-6)
      return bad_input(place + ".matrix must end its four columns with 0, 0, 0 and 1");
    return given;
  }
  Vec3 move = Vec3::Zero();
  Vec3 scale = Vec3::Ones();
  std::array<double, 4> turn{0, 0, 0, 1};
  if (!read_numbers(node, "translation", 3, move.data()) || !read_numbers(node, "scale", 3, scale.data()))
    return bad_input(place + ": translation and scale must be lists of 3 numbers");
  if (!read_numbers(node, "rotation", 4, turn.data()))
    return bad_input(place + ".rotation must be a list of 4 numbers");
  const Eigen::Quaterniond rotation(turn[3], turn[0], turn[1], turn[2]);
  if (!(rotation.norm() > 0) || !std::isfinite(rotation.norm()))
    return bad_input(place + ".rotation must have a length");
  Transform transform = Transform::Identity();
  transform.topLeftCorner<3, 3>() = rotation.normalized().toRotationMatrix() * scale.asDiagonal();
  transform.topRightCorner<3, 1>() = move;
  return transform;
}

/// Reads what the nodes of a scene place. Invariant: every corner of `mesh_` exists.
class SceneReader {
 public:
  explicit SceneReader(GltfDocument& document) : document_(document) {}

  Result<TriangleMesh> read(const JsonValue& scene) {
    const Status walked = walk(scene);
    if (!walked) return walked.error();
    return std::move(mesh_);
  }

  /// The same, but each mesh is read once and stays in its own frame.
  Result<GltfNodes> read_nodes(const JsonValue& scene) {
    apart_ = true;
    const Status walked = walk(scene);
    if (!walked) return walked.error();
    std::erase_if(nodes_.nodes, [&](const GltfNode& node) { return nodes_.meshes[node.mesh].triangles.empty(); });
    return std::move(nodes_);
  }

 private:
  Status walk(const JsonValue& scene) {
    reached_.assign(document_.entries(GltfList::Nodes).size(), false);
    Status read = Done{};
    if (const JsonValue* nodes = scene.find("nodes")) read = enter(*nodes, "scene.nodes", Transform::Identity());
    while (read && !open_.empty()) {
      NodeList& list = open_.back();
      if (list.next == list.nodes->items().size()) {
        open_.pop_back();
      } else {
        const std::size_t i = list.next++;
        const Transform parent = list.parent;  // a list that is entered moves this one
        read = read_node(list.nodes->items()[i], parent);
      }
    }
    return read;
  }

  /// A list of nodes that is being read, with the transform of their parent.
  struct NodeList {
    const JsonValue* nodes;
    std::size_t next = 0;
    Transform parent;
  };

  Status enter(const JsonValue& nodes, const std::string& place, const Transform& parent) {
    if (!nodes.is_array()) return bad_input(place + " must be a list of nodes");
    open_.push_back({&nodes, 0, parent});
    return Done{};
  }

  Status read_node(const JsonValue& name, const Transform& parent) {
    const auto entry = document_.find(GltfList::Nodes, name);
    if (!entry) return bad_input(fmt::format("a list of nodes names {}, must exist", io::shown(name)));
    const std::string place = document_.place(GltfList::Nodes, *entry);
    if (reached_[*entry]) return bad_input(place + " is its own descendant or has two parents, nodes must be a tree");
    reached_[*entry] = true;
    const JsonValue& node = document_.entries(GltfList::Nodes)[*entry];
    if (!node.is_object()) return bad_input(place + " must be an object");
    const JsonValue* extensions = node.find("extensions");
    if (extensions != nullptr && extensions->find("EXT_mesh_gpu_instancing") != nullptr)
      return bad_input(place + " has instances by EXT_mesh_gpu_instancing, must be nodes");
    const Result<Transform> own = transform_of(node, place);
    if (!own) return own.error();
    const Transform transform = parent * own.value();
    const JsonValue* called = node.find("name");
    name_ = called != nullptr ? called->text() : std::string_view{};
    Status read = Done{};
    if (const JsonValue* mesh = node.find("mesh")) read = read_mesh(*mesh, place, transform);
    // Version 1 has several meshes in a node.
    if (const JsonValue* meshes = node.find("meshes"); meshes != nullptr && read) {
      for (std::size_t i = 0; i < meshes->items().size() && read; ++i)
        read = read_mesh(meshes->items()[i], place, transform);
    }
    const JsonValue* children = node.find("children");
    return read && children != nullptr ? enter(*children, place + ".children", transform) : read;
  }

  Status read_mesh(const JsonValue& name, const std::string& node_place, const Transform& transform) {
    if (const Status charged = document_.charge(name); !charged) return charged;
    const auto entry = document_.find(GltfList::Meshes, name);
    if (!entry) return bad_input(fmt::format("{}.mesh = {}, must exist", node_place, io::shown(name)));
    const JsonValue& mesh = document_.entries(GltfList::Meshes)[*entry];
    if (apart_) return add_node(*entry, mesh, node_place, transform);
    return read_primitives(*entry, mesh, transform);
  }

  /// Notes where a mesh is, and reads it where it is met first.
  Status add_node(std::size_t entry, const JsonValue& mesh, const std::string& node_place, const Transform& transform) {
    const auto [found, added] = read_already_.try_emplace(entry, nodes_.meshes.size());
    if (added) {
      const Status read = read_primitives(entry, mesh, Transform::Identity());
      if (!read) return read;
      nodes_.meshes.push_back(std::exchange(mesh_, {}));
    }
    std::string_view called = name_;
    if (const JsonValue* own = mesh.find("name"); called.empty() && own != nullptr) called = own->text();
    if (const Status charged = document_.charge(called.size() + 20); !charged) return charged;
    nodes_.nodes.push_back({called.empty() ? node_place : std::string(called), found->second, transform});
    return Done{};
  }

  Status read_primitives(std::size_t entry, const JsonValue& mesh, const Transform& transform) {
    if (const Status charged = document_.charge(mesh); !charged) return charged;
    const JsonValue* primitives = mesh.find("primitives");
    const std::string place = document_.place(GltfList::Meshes, entry) + ".primitives";
    if (primitives == nullptr || !primitives->is_array()) return bad_input(place + " must be a list");
    for (std::size_t i = 0; i < primitives->items().size(); ++i) {
      const Status read = read_primitive(primitives->items()[i], transform);
      if (!read) return bad_input(fmt::format("{}[{}]: {}", place, i, read.error().message));
    }
    return Done{};
  }

  Status read_primitive(const JsonValue& primitive, const Transform& transform) {
    // "primitive" is what drafts of version 1 called it.
    const auto mode = whole_member(primitive, primitive.find("mode") != nullptr ? "mode" : "primitive", kTriangles);
    if (!mode || *mode > kFan) return bad_input("mode must be a whole number from 0 to 6");
    const JsonValue* attributes = primitive.find("attributes");
    const JsonValue* extensions = primitive.find("extensions");
    for (const JsonValue* looked_at : {&primitive, attributes, extensions}) {
      if (looked_at == nullptr) continue;
      if (const Status charged = document_.charge(*looked_at); !charged) return charged;
    }
    const JsonValue* position = attributes != nullptr ? attributes->find("POSITION") : nullptr;
    if (position == nullptr) return Done{};
    if (extensions != nullptr && extensions->find("KHR_draco_mesh_compression") != nullptr)
      return bad_input(
          "is compressed by KHR_draco_mesh_compression, must be decompressed before, by Blender or "
          "gltf-transform for example");
    const std::size_t base = mesh_.vertices_m.size();
    if (const Status read = document_.add_points(*position, mesh_.vertices_m); !read) return read;
    const std::size_t points = mesh_.vertices_m.size() - base;
    if (const JsonValue* indices = primitive.find("indices")) {
      if (const Status read = document_.read_indices(*indices, corners_); !read) return read;
    } else {
      if (const Status charged = document_.charge(points); !charged) return charged;
      corners_.resize(points);
      std::iota(corners_.begin(), corners_.end(), 0U);
    }
    return place_primitive(base, *mode, transform);
  }

  /// Moves the vertices from `base` on to where the node has them and adds the triangles of `corners_`.
  Status place_primitive(std::size_t base, std::uint64_t mode, const Transform& transform) {
    const std::size_t points = mesh_.vertices_m.size() - base;
    for (std::size_t i = 0; i < points; ++i) {
      Vec3& point = mesh_.vertices_m[base + i];
      const Vec3 placed = (transform * point.homogeneous()).head<3>();
      if (!point.allFinite() || !placed.allFinite())
        return bad_input(fmt::format("vertex {} is ({}, {}, {}), must be finite", i, point.x(), point.y(), point.z()));
      point = placed;
    }
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (corners_[i] >= points)
        return bad_input(fmt::format("indices: value {} = {}, must be below {}", i, corners_[i], points));
    }
    if (mode < kTriangles) return Done{};  // points and lines
    const bool mirrored = transform.topLeftCorner<3, 3>().determinant() < 0;
    const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(base + corners_[i]); };
    const auto triangle = [&](std::size_t a, std::size_t b, std::size_t c) {
      mesh_.triangles.push_back({at(a), at(mirrored ? c : b), at(mirrored ? b : c)});
    };
    // Corners beyond the last whole triangle are left out, as the format requires.
    if (mode == kTriangles) {
      for (std::size_t i = 0; i + 2 < corners_.size(); i += 3) triangle(i, i + 1, i + 2);
    } else {
      for (std::size_t i = 0; i + 2 < corners_.size(); ++i) {
        if (mode == kFan) triangle(0, i + 1, i + 2);
        if (mode == kStrip) triangle(i, i + 1 + i % 2, i + 2 - i % 2);
      }
    }
    return Done{};
  }

  GltfDocument& document_;
  TriangleMesh mesh_;
  std::vector<bool> reached_;
  std::vector<NodeList> open_;          ///< the innermost last
  std::vector<std::uint32_t> corners_;  ///< of the primitive that is read
  std::string_view name_;               ///< of the node that is read
  bool apart_ = false;                  ///< nodes_ is filled instead of mesh_
  GltfNodes nodes_;
  std::map<std::size_t, std::size_t> read_already_;  ///< by mesh of the file: that of nodes_
};

/// The scene that is to be shown; a single one is shown whatever the file says.
Result<std::size_t> chosen_scene(const GltfDocument& document) {
  const std::size_t scenes = document.entries(GltfList::Scenes).size();
  if (scenes == 0) return bad_input("has no scene, so nothing of it is to be shown");
  const JsonValue* choice = document.root().find("scene");
  if (scenes == 1 || choice == nullptr) return std::size_t{0};
  const auto found = document.find(GltfList::Scenes, *choice);
  if (found) return *found;
  return bad_input(fmt::format("scene = {}, must be one of {} scenes", io::shown(*choice), scenes));
}

}  // namespace

Result<TriangleMesh> parse_gltf(std::string_view bytes, const std::filesystem::path& folder) {
  Result<GltfDocument> document = GltfDocument::open(bytes, folder);
  if (!document) return document.error();
  const Result<std::size_t> scene = chosen_scene(document.value());
  if (!scene) return scene.error();
  return SceneReader(document.value()).read(document.value().entries(GltfList::Scenes)[scene.value()]);
}

Result<GltfNodes> parse_gltf_nodes(std::string_view bytes, const std::filesystem::path& folder) {
  Result<GltfDocument> document = GltfDocument::open(bytes, folder);
  if (!document) return document.error();
  const Result<std::size_t> scene = chosen_scene(document.value());
  if (!scene) return scene.error();
  return SceneReader(document.value()).read_nodes(document.value().entries(GltfList::Scenes)[scene.value()]);
}

}  // namespace poise::geometry
