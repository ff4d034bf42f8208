// SPDX-License-Identifier: MIT
#include "shapes.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

#include "arrays.h"
#include "poise/assets/mesh_file.h"
#include "poise/assets/tree_formats.h"

namespace poise::python {
namespace {

constexpr std::array<std::string_view, 3> kPresets{"fast", "default", "best"};

/// How the tree of a mesh is made.
struct TreeArguments {
  TreeBuildOptions build;
  double shell_thickness_m = 0;
  std::optional<TreeCacheSettings> cache;
};

TreeArguments tree_arguments(const py::object& depth, const std::string& preset, double shell_thickness_m,
                             std::uint64_t seed, const py::object& threads, const py::object& tree_cache) {
  TreeArguments arguments;
  arguments.build.depth = static_cast<Level>(whole_of("depth", depth, kMaxTreeDepth));
  arguments.build.preset = static_cast<TreePreset>(index_of("preset", preset, kPresets));
  arguments.build.seed = seed;
  arguments.build.threads = static_cast<int>(whole_of("threads", threads, 256));
  if (shell_thickness_m != 0) arguments.build.solidity = Solidity::Shell;
  arguments.shell_thickness_m = shell_thickness_m;
  arguments.cache = tree_cache_of(tree_cache);
  return arguments;
}

Result<ShapePtr> make_mesh(const TriangleMesh& mesh, const TreeArguments& arguments) {
  if (!arguments.cache) return make_mesh_shape(mesh, arguments.build, arguments.shell_thickness_m);
  const Result<SphereTree> tree = cached_sphere_tree(mesh, arguments.build, *arguments.cache);
  if (!tree) return tree.error();
  return make_mesh_shape_with_tree(mesh, tree.value(), arguments.shell_thickness_m);
}

ShapeValue shape_of_mesh(const TriangleMesh& mesh, const TreeArguments& arguments) {
  Result<ShapePtr> made = [&] {
    const WithoutLock others;
    return make_mesh(mesh, arguments);
  }();
  return {taken(std::move(made))};
}

TriangleMesh mesh_of(const py::object& vertices_m, const py::object& triangles) {
  const auto points = rows_of<double>("vertices_m", vertices_m, 3);
  const auto corners = rows_of<std::int64_t>("triangles", triangles, 3);
  TriangleMesh mesh;
  for (py::ssize_t i = 0; i < points.shape(0); ++i)
    mesh.vertices_m.emplace_back(points.at(i, 0), points.at(i, 1), points.at(i, 2));
  for (py::ssize_t i = 0; i < corners.shape(0); ++i) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int64_t corner = corners.at(i, static_cast<py::ssize_t>(k));
      if (corner < 0 || corner >= points.shape(0))
        raise(bad_input("triangles[" + std::to_string(i) + "] = " + std::to_string(corner) + ", must be in [0, " +
                        std::to_string(points.shape(0)) + "): it is the number of a vertex"));
      triangle[k] = static_cast<std::uint32_t>(corner);
    }
    mesh.triangles.push_back(triangle);
  }
  clean_mesh(mesh, 1e-6);
  return mesh;
}

TriangleMesh box_mesh(const Vec3& half) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 8; ++i)
    mesh.vertices_m.emplace_back((i & 1U) != 0 ? half.x() : -half.x(), (i & 2U) != 0 ? half.y() : -half.y(),
                                 (i & 4U) != 0 ? half.z() : -half.z());
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

std::vector<Sphere> spheres_of(const py::object& centers_m, const py::object& radii_m) {
  const auto centers = rows_of<double>("centers_m", centers_m, 3);
  const auto radii = rows_of<double>("radii_m", radii_m, 1);
  if (centers.shape(0) != radii.shape(0))
    raise(bad_input("radii_m, must have as many entries (" + std::to_string(radii.shape(0)) +
                    ") as centers_m has rows (" + std::to_string(centers.shape(0)) + ")"));
  std::vector<Sphere> spheres;
  for (py::ssize_t i = 0; i < radii.shape(0); ++i)
    spheres.push_back({{centers.at(i, 0), centers.at(i, 1), centers.at(i, 2)}, radii.at(i)});
  return spheres;
}

py::tuple spheres_at(const ShapeValue& value, const py::object& level) {
  const SphereTree& tree = value.shape->tree;
  const auto wanted = static_cast<Level>(whole_of("level", level, kMaxTreeDepth));
  std::vector<double> centers, radii;
  if (value.shape->kind == ShapeKind::Tree) {
    for (const NodeIndex node : tree.nodes_at(wanted)) {
      const Sphere sphere = tree.sphere(node);
      centers.insert(centers.end(), {sphere.center_m.x(), sphere.center_m.y(), sphere.center_m.z()});
      radii.push_back(sphere.radius_m);
    }
  }
  const auto count = static_cast<py::ssize_t>(radii.size());
  return py::make_tuple(owned(std::move(centers), {count, 3}), owned(std::move(radii), {count}));
}

void bind_makers(py::class_<ShapeValue>& bound) {
  bound
      .def_static(
          "sphere", [](double radius_m) { return ShapeValue{taken(make_sphere_shape(radius_m))}; }, py::arg("radius_m"),
          "A ball about its centre; radius in [1e-9, 1e9] metres.")
      .def_static(
          "plane",
          [](const VectorArgument& normal, double offset_m) {
            return ShapeValue{taken(make_plane_shape(vec3_of("normal", normal), offset_m))};
          },
          py::arg("normal") = py::make_tuple(0.0, 0.0, 1.0), py::arg("offset_m") = 0.0,
          "The half-space normal . x <= offset_m (metres), for static bodies alone. `normal` may have any length but "
          "0.")
      .def_static(
          "spheres",
          [](const py::object& centers_m, const py::object& radii_m) {
            return ShapeValue{taken(make_spheres_shape(spheres_of(centers_m, radii_m)))};
          },
          py::arg("centers_m"), py::arg("radii_m"),
          "A rigid union of balls: centres (n, 3) and radii (n,), metres; at most 32768.")
      .def_static(
          "from_file",
          [](const py::object& path, double scale, const py::object& depth, const std::string& preset,
             double shell_thickness_m, std::uint64_t seed, const py::object& threads, const py::object& tree_cache) {
            MeshReadOptions read;
            read.scale = scale;
            const TriangleMesh mesh = taken(read_mesh(path_of(path), read));
            return shape_of_mesh(mesh, tree_arguments(depth, preset, shell_thickness_m, seed, threads, tree_cache));
          },
          py::arg("path"), py::kw_only(), py::arg("scale") = 1.0, py::arg("depth") = 3, py::arg("preset") = "default",
          py::arg("shell_thickness_m") = 0.0, py::arg("seed") = 1, py::arg("threads") = 0,
          py::arg("tree_cache") = py::none(),
          "As `mesh`, from an OBJ, STL, PLY, OFF, glTF or GLB file; `scale` is metres per unit of the file.")
      .def_static(
          "from_spheres_file",
          [](const py::object& path) {
            return ShapeValue{taken(make_spheres_shape(taken(read_spheres(path_of(path)))))};
          },
          py::arg("path"),
          "The deepest set of spheres of a tree file: .sph, .urdf, .yml (cuRobo) or .json (foam); metres.");
}

void bind_mesh_makers(py::class_<ShapeValue>& bound) {
  bound
      .def_static(
          "mesh",
          [](const py::object& vertices_m, const py::object& triangles, const py::object& depth,
             const std::string& preset, double shell_thickness_m, std::uint64_t seed, const py::object& threads,
             const py::object& tree_cache) {
            return shape_of_mesh(mesh_of(vertices_m, triangles),
                                 tree_arguments(depth, preset, shell_thickness_m, seed, threads, tree_cache));
          },
          py::arg("vertices_m"), py::arg("triangles"), py::kw_only(), py::arg("depth") = 3,
          py::arg("preset") = "default", py::arg("shell_thickness_m") = 0.0, py::arg("seed") = 1,
          py::arg("threads") = 0, py::arg("tree_cache") = py::none(),
          R"(A shape of triangles, with a sphere tree that is built for it.

vertices_m: (n, 3) metres. triangles: (m, 3) numbers of vertices, counter-clockwise from outside; the mesh is
welded and cleaned first. depth: levels below the root, 0 to 6. preset: 'fast', 'default' or 'best'.
shell_thickness_m > 0: the surface alone, with the mass of plates of this thickness. threads: 0 is as many as
the machine has; the tree does not depend on it. tree_cache: None for POISE_TREE_CACHE or else the user's cache,
False for none, or a folder. Building releases the global lock and takes seconds for large meshes.)")
      .def_static(
          "box",
          [](const VectorArgument& half_extents_m, const py::object& depth, const py::object& tree_cache) {
            const Vec3 half = vec3_of("half_extents_m", half_extents_m);
            if (!(half.minCoeff() > 0)) {
              raise(bad_input("half_extents_m = " + py::repr(half_extents_m.given).cast<std::string>() +
                              ", each must be > 0"));
            }
            return shape_of_mesh(box_mesh(half), tree_arguments(depth, "default", 0, 1, py::int_(0), tree_cache));
          },
          py::arg("half_extents_m"), py::kw_only(), py::arg("depth") = 3, py::arg("tree_cache") = py::none(),
          "A solid box of 12 triangles about its centre, with these half sides (metres); otherwise as `mesh`.");
}

}  // namespace

std::filesystem::path path_of(const py::object& given) {
  return py::module_::import("os").attr("fspath")(given).cast<std::string>();
}

std::optional<TreeCacheSettings> tree_cache_of(const py::object& given) {
  TreeCacheSettings settings;
  if (py::isinstance<py::bool_>(given)) {
    if (!given.cast<bool>()) return std::nullopt;
  } else if (!given.is_none()) {
    settings.folder = path_of(given);
    return settings;
  }
  if (const char* value = std::getenv("POISE_TREE_CACHE"); value != nullptr) {
    const std::string_view text = value;
    if (text.empty() || text == "off") return std::nullopt;
    settings.folder = text;
  }
  return settings;
}

void bind_shapes(py::module_& module) {
  py::class_<ShapeValue> bound(module, "Shape",
                               R"(The part of a body that bodies share: a sphere tree and mass properties. Immutable.

Made by sphere, plane, spheres, box, mesh, from_file or from_spheres_file; any number of bodies and Worlds may
use it.)");
  bind_makers(bound);
  bind_mesh_makers(bound);
  bound
      .def_property_readonly(
          "kind", [](const ShapeValue& s) { return s.shape->kind == ShapeKind::Plane ? "plane" : "tree"; },
          "'tree' or 'plane'.")
      .def_property_readonly(
          "volume_m3", [](const ShapeValue& s) { return s.shape->volume_m3; }, "Volume, m^3; 0 for a plane.")
      .def_property_readonly(
          "bounding_radius_m", [](const ShapeValue& s) { return s.shape->bounding_radius_m; },
          "Of a ball about the centre of mass that contains it, metres.")
      .def_property_readonly(
          "origin_offset_m", [](const ShapeValue& s) { return tuple_of(s.shape->origin_offset_m); },
          "From the origin of mesh or spheres to the centre of mass, metres.")
      .def_property_readonly(
          "depth", [](const ShapeValue& s) { return s.shape->tree.depth(); }, "Level of the deepest node of the tree.")
      .def_property_readonly(
          "note", [](const ShapeValue& s) { return s.shape->note; },
          "What is uncertain about inside and mass, one line; empty if nothing is.")
      .def("spheres_at", &spheres_at, py::arg("level"),
           "Spheres of a level of the tree: (centres (n, 3), radii (n,)), metres, about the centre of mass. A copy.")
      .def("__repr__", [](const ShapeValue& s) {
        if (s.shape->kind == ShapeKind::Plane) return std::string("<poise.Shape plane>");
        return "<poise.Shape tree of " + std::to_string(s.shape->tree.node_count()) + " spheres, depth " +
               std::to_string(s.shape->tree.depth()) + ">";
      });
}

}  // namespace poise::python
