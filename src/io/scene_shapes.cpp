// SPDX-License-Identifier: MIT
#include "io/scene_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "io/json_document.h"
#include "parallel/executor.h"

namespace poise::io {
namespace {

/// Makes the shape of each kind of source.
struct Loader {
  const Scene& scene;
  int threads;

  [[nodiscard]] std::filesystem::path found(const std::filesystem::path& file) const {
    return file.is_absolute() ? file : scene.base / file;
  }
  Result<ShapePtr> operator()(const SphereSource& source) const { return make_sphere_shape(source.radius_m); }
  Result<ShapePtr> operator()(const PlaneSource& source) const {
    return make_plane_shape(source.normal, source.offset_m);
  }
  Result<ShapePtr> operator()(const SpheresSource& source) const { return make_spheres_shape(source.spheres); }
  Result<ShapePtr> operator()(const MeshSource& source) const {
    MeshReadOptions read;
    read.scale = source.scale;
    const Result<TriangleMesh> mesh = read_mesh(found(source.file), read);
    if (!mesh) return mesh.error();
    TreeBuildOptions build;
    build.depth = source.depth;
    build.threads = threads;
    return make_mesh_shape(mesh.value(), build, source.shell_thickness_m);
  }
  Result<ShapePtr> operator()(const TreeSource& source) const {
    Result<SphereTree> tree = read_sph(found(source.file));
    if (!tree) return tree.error();
    return make_tree_shape(scaled_tree(std::move(tree).value(), source.scale));
  }
};

const char* kind_name(const SceneShape& shape) {
  constexpr const char* kNames[] = {"sphere", "plane", "mesh", "spheres", "tree"};
  return kNames[shape.source.index()];
}

/// File and field of a shape, for messages.
std::string place_of(const Scene& scene, const SceneShape& shape) {
  return scene.source + ": " + member_path(member_path("shapes", shape.name), kind_name(shape));
}

}  // namespace

std::vector<std::string> shape_warnings(const Scene& scene, std::span<const ShapePtr> shapes) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < scene.shapes.size() && i < shapes.size(); ++i) {
    if (!shapes[i]->note.empty()) warnings.push_back(place_of(scene, scene.shapes[i]) + ": " + shapes[i]->note);
  }
  return warnings;
}

SphereTree scaled_tree(SphereTree tree, double scale) {
  if (scale == 1) return tree;
  const auto scaled = [scale](float value) { return static_cast<float>(static_cast<double>(value) * scale); };
  for (std::size_t i = 0; i < tree.node_count(); ++i) {
    // Rounding moves a centre by up to half a unit in the last place of each coordinate, of the node and of what it
    // covers.
    const float reach = std::abs(tree.x_m[i]) + std::abs(tree.y_m[i]) + std::abs(tree.z_m[i]) + tree.radius_m[i];
    for (std::vector<float>* values :
         {&tree.x_m, &tree.y_m, &tree.z_m, &tree.radius_m, &tree.protrusion_max_m, &tree.protrusion_mean_m}) {
      (*values)[i] = scaled((*values)[i]);
    }
    if (tree.child_count[i] > 0) tree.radius_m[i] += 4 * std::numeric_limits<float>::epsilon() * scaled(reach);
  }
  return tree;
}

Result<std::vector<ShapePtr>> load_shapes(const Scene& scene, int threads) {
  // Side by side, each on one thread, where there is more than one to build: the roots of trees are split by one thread.
  const auto meshes = std::count_if(scene.shapes.begin(), scene.shapes.end(), [](const SceneShape& shape) {
    return std::holds_alternative<MeshSource>(shape.source);
  });
  const Loader loader{scene, meshes > 1 ? 1 : threads};
  std::vector<Result<ShapePtr>> made(scene.shapes.size(), Result<ShapePtr>(ShapePtr{}));
  const auto executor = parallel::make_executor(ExecutorKind::Threads, threads);
  parallel::parallel_for(*executor, made.size(), 1, [&](std::size_t i, std::size_t, int) {
    made[i] = std::visit(loader, scene.shapes[i].source);
  });
  std::vector<ShapePtr> shapes;
  for (std::size_t i = 0; i < made.size(); ++i) {
    if (!made[i]) {
      return Error{made[i].error().kind, place_of(scene, scene.shapes[i]) + ": " + made[i].error().message};
    }
    shapes.push_back(std::move(made[i]).value());
  }
  return shapes;
}

}  // namespace poise::io
