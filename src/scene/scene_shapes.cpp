// SPDX-License-Identifier: MIT
#include "scene/scene_shapes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "assets/json/json_document.h"
#include "parallel/executor.h"
#include "parallel/interrupt.h"
#include "parallel/shared_counters.h"
#include "poise/assets/mesh_file.h"
#include "poise/assets/sph_file.h"
#include "poise/assets/tree_formats.h"

namespace poise::io {
namespace {

/// Rotates a mesh; a rotation by quarter turns does not round coordinates.
void turn(TriangleMesh& mesh, const Quat& rotation) {
  Mat3 matrix = rotation.toRotationMatrix();
  const Mat3 rounded = matrix.array().round();
  if ((matrix - rounded).cwiseAbs().maxCoeff() < 1e-12) matrix = rounded;
  for (Vec3& vertex : mesh.vertices_m) vertex = matrix * vertex;
}

/// Makes the shape of each kind of source, and counts the outcomes of the cache.
struct Loader {
  const Scene& scene;
  int threads;
  const std::optional<TreeCacheSettings>& tree_cache;
  TreeCacheUse& use;
  std::function<void(double)> progress = {};
  std::stop_token stop = {};

  [[nodiscard]] std::filesystem::path found(const std::filesystem::path& file) const { return scene.base / file; }
  Result<ShapePtr> operator()(const SphereSource& source) const { return make_sphere_shape(source.radius_m); }
  Result<ShapePtr> operator()(const PlaneSource& source) const {
    return make_plane_shape(source.normal, source.offset_m);
  }
  Result<ShapePtr> operator()(const SpheresSource& source) const {
    return make_spheres_shape(source.spheres, {threads, stop});
  }
  [[nodiscard]] Result<TriangleMesh> turned_mesh_of(const MeshSource& source) const {
    Result<TriangleMesh> mesh = mesh_of(source.file, source.scale);
    if (mesh && source.turned) turn(mesh.value(), source.rotation);
    return mesh;
  }
  [[nodiscard]] Result<TriangleMesh> mesh_of(const std::filesystem::path& file, double scale) const {
    MeshReadOptions read;
    read.scale = scale;
    return read_mesh(found(file), read);
  }
  Result<ShapePtr> operator()(const MeshSource& source) const {
    const Result<TriangleMesh> mesh = turned_mesh_of(source);
    if (!mesh) return mesh.error();
    TreeBuildOptions build;
    build.depth = source.depth;
    build.threads = threads;
    build.progress = progress;
    build.stop = stop;
    if (!tree_cache || !tree_cache->on) {
      ++use.off;
      return make_mesh_shape(mesh.value(), build, source.shell_thickness_m);
    }
    if (source.shell_thickness_m > 0) build.solidity = Solidity::Shell;
    TreeCacheOutcome outcome{};
    const Result<SphereTree> tree = cached_sphere_tree(mesh.value(), build, *tree_cache, &outcome, &use.evicted);
    if (!tree) return tree.error();
    count(outcome);
    return make_mesh_shape_with_tree(mesh.value(), tree.value(), source.shell_thickness_m);
  }
  Result<ShapePtr> operator()(const TreeSource& source) const {
    Result<SphereTree> tree = read_sph(found(source.file));
    if (!tree) return tree.error();
    if (source.mesh.empty()) return make_tree_shape(scaled_tree(std::move(tree).value(), source.scale, true));
    const Result<TriangleMesh> mesh = mesh_of(source.mesh, source.scale);
    if (!mesh) return mesh.error();
    return adopted(source, scaled_tree(std::move(tree).value(), source.scale, false), mesh.value());
  }

  /// A shape from a tree of another program, whose coverage of its mesh is measured before it is used.
  [[nodiscard]] Result<ShapePtr> adopted(const TreeSource& source, SphereTree tree, const TriangleMesh& mesh) const {
    TreeQualityOptions adopt;
    adopt.threads = threads;
    if (source.shell_thickness_m > 0) adopt.solidity = Solidity::Shell;
    const Result<ForeignTreeReport> report = adopt_tree(tree, mesh, adopt);
    if (!report) return report.error();
    const std::string measured = source.file.string() + " on " + source.mesh.string() + ": " + report.value().summary();
    if (!report.value().covers_surface() && !source.allow_leaks) {
      return bad_input(measured +
                       "; contacts where it leaks would be missed (\"allow_leaks\": true uses it all the same)");
    }
    Result<ShapePtr> made = make_mesh_shape_with_tree(mesh, tree, source.shell_thickness_m);
    if (!made || (report.value().covers_surface() && report.value().inside_coverage >= 1)) return made;
    auto noted = std::make_shared<Shape>(*made.value());
    noted->note += (noted->note.empty() ? "" : "; ") + measured;
    return ShapePtr(std::move(noted));
  }

  void count(TreeCacheOutcome outcome) const {
    switch (outcome) {
      case TreeCacheOutcome::Off:
        ++use.off;
        break;
      case TreeCacheOutcome::Hit:
        ++use.hits;
        break;
      case TreeCacheOutcome::Built:
        ++use.built;
        break;
      case TreeCacheOutcome::Rebuilt:
        ++use.rebuilt;
        break;
      case TreeCacheOutcome::NotWritable:
        ++use.not_writable;
        break;
    }
  }
};

void add(const TreeCacheUse& more, TreeCacheUse& sum) {
  for (std::size_t TreeCacheUse::*part :
       {&TreeCacheUse::off, &TreeCacheUse::hits, &TreeCacheUse::built, &TreeCacheUse::rebuilt,
        &TreeCacheUse::not_writable, &TreeCacheUse::evicted}) {
    sum.*part += more.*part;
  }
}

const char* kind_name(const SceneShape& shape) {
  constexpr const char* kNames[] = {"sphere", "plane", "mesh", "spheres", "tree"};
  return kNames[shape.source.index()];
}

}  // namespace

std::string place_of(const Scene& scene, const SceneShape& shape) {
  return scene.source + ": " + member_path(member_path("shapes", shape.name), kind_name(shape));
}

Result<TriangleMesh> scene_mesh(const Scene& scene, const MeshSource& source) {
  TreeCacheUse unused;
  return Loader{scene, 0, {}, unused}.turned_mesh_of(source);
}

Result<ShapePtr> load_without_building(const Scene& scene, const SceneShape& shape, const LoadSettings& settings) {
  // Without its tree nothing is known of a union.
  if (const auto* spheres = std::get_if<SpheresSource>(&shape.source))
    return make_spheres_shape(spheres->spheres, {settings.threads, settings.stop});
  TreeCacheUse unused;
  return std::visit(Loader{scene, settings.threads, settings.tree_cache, unused, {}, parallel::stopped_token()},
                    shape.source);
}

std::vector<std::string> shape_warnings(const Scene& scene, std::span<const ShapePtr> shapes) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < scene.shapes.size() && i < shapes.size(); ++i) {
    if (!shapes[i]->note.empty()) warnings.push_back(place_of(scene, scene.shapes[i]) + ": " + shapes[i]->note);
  }
  return warnings;
}

SphereTree scaled_tree(SphereTree tree, double scale, bool leaves_are_surface) {
  if (scale == 1) return tree;
  const auto scaled = [scale](float value) { return static_cast<float>(static_cast<double>(value) * scale); };
  for (std::size_t i = 0; i < tree.node_count(); ++i) {
    // Rounding moves a centre by up to half a unit in the last place of each coordinate; this holds for the node and
    // for the spheres that it covers.
    const float reach = std::abs(tree.x_m[i]) + std::abs(tree.y_m[i]) + std::abs(tree.z_m[i]) + tree.radius_m[i];
    for (std::vector<float>* values :
         {&tree.x_m, &tree.y_m, &tree.z_m, &tree.radius_m, &tree.protrusion_max_m, &tree.protrusion_mean_m}) {
      (*values)[i] = scaled((*values)[i]);
    }
    if (tree.child_count[i] > 0 || !leaves_are_surface)
      tree.radius_m[i] += 4 * std::numeric_limits<float>::epsilon() * scaled(reach);
  }
  return tree;
}

Result<LoadedShapes> load_shapes(const Scene& scene, const LoadSettings& settings) {
  // Several meshes are built in parallel, each on one thread, since the root of a tree is split by one thread.
  const auto meshes = std::count_if(scene.shapes.begin(), scene.shapes.end(), [](const SceneShape& shape) {
    return std::holds_alternative<MeshSource>(shape.source);
  });
  const int threads = meshes > 1 ? 1 : settings.threads;
  parallel::Shared<std::size_t> done;
  std::vector<Result<ShapePtr>> made(scene.shapes.size(), Result<ShapePtr>(ShapePtr{}));
  std::vector<TreeCacheUse> uses(made.size());
  const auto executor = parallel::make_executor(ExecutorKind::Threads, meshes > 1 ? settings.threads : 1);
  parallel::parallel_for(*executor, made.size(), 1, [&](std::size_t i, std::size_t, int worker) {
    std::function<void(double)> progress;
    // Worker 0 is the calling thread, the only one that reports progress; a single mesh is built by it.
    if (worker == 0 && settings.progress)
      progress = [&](double share) {
        settings.progress((static_cast<double>(done.get()) + share) / static_cast<double>(made.size()));
      };
    const Loader loader{scene, threads, settings.tree_cache, uses[i], progress, settings.stop};
    made[i] = settings.stop.stop_requested() ? Error{ErrorKind::Cancelled, "the loading of the shapes was stopped"}
                                             : std::visit(loader, scene.shapes[i].source);
    done.add(1);
  });
  LoadedShapes loaded;
  for (std::size_t i = 0; i < made.size(); ++i) {
    if (!made[i]) return Error{made[i].error().kind, place_of(scene, scene.shapes[i]) + ": " + made[i].error().message};
    loaded.shapes.push_back(std::move(made[i]).value());
    add(uses[i], loaded.tree_cache_use);
  }
  return loaded;
}

std::vector<std::filesystem::path> files_of(const Scene& scene) {
  std::vector<std::filesystem::path> files;
  const auto add = [&](const std::filesystem::path& file) {
    if (!file.empty()) files.push_back(scene.base / file);
  };
  for (const SceneShape& shape : scene.shapes) {
    if (const auto* mesh = std::get_if<MeshSource>(&shape.source)) add(mesh->file);
    if (const auto* tree = std::get_if<TreeSource>(&shape.source)) {
      add(tree->file);
      add(tree->mesh);
    }
  }
  if (scene.gaze) add(scene.gaze->file);
  return files;
}

}  // namespace poise::io
