// SPDX-License-Identifier: MIT
#include "app/tree/robot_files.h"

#include <fmt/format.h>

#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "assets/tree/tree_files.h"
#include "geometry/mesh/solids.h"
#include "poise/assets/mesh_file.h"

namespace poise::app {
namespace {

namespace fs = std::filesystem;

/// The folder of a package that nobody named: empty if there is none.
fs::path found_package(const std::string& name, const fs::path& folder) {
  std::error_code failure;
  fs::path here = fs::absolute(folder, failure).lexically_normal();
  if (here.filename().empty()) here = here.parent_path();
  for (;;) {
    if (here.filename() == name) return here;
    if (fs::is_directory(here / name, failure)) return here / name;
    if (!here.has_relative_path()) return {};
    here = here.parent_path();
  }
}

Result<fs::path> in_package(const std::string& rest, const RobotFolders& folders) {
  const std::size_t slash = rest.find('/');
  const std::string name = rest.substr(0, slash);
  if (slash == std::string::npos || name.empty() || name == "." || name == "..")
    return bad_input("must be package://NAME/FILE");
  for (const std::string& package : folders.packages) {
    if (package.starts_with(name + "=")) return fs::path(package.substr(name.size() + 1)) / rest.substr(slash + 1);
  }
  const fs::path found = found_package(name, folders.folder);
  if (!found.empty()) return found / rest.substr(slash + 1);
  return bad_input(fmt::format("no folder '{0}' beside or above the URDF, --package {0}=FOLDER names it", name));
}

Result<TriangleMesh> mesh_of_part(const geometry::UrdfPart& part, const RobotFolders& folders) {
  switch (part.solid) {
    case geometry::UrdfSolid::Box:
      return geometry::box_solid(part.size_m / 2);
    case geometry::UrdfSolid::Cylinder:
      return geometry::cylinder_solid(part.size_m.x(), part.size_m.y() / 2);
    case geometry::UrdfSolid::Sphere:
      return geometry::ellipsoid_solid(Vec3::Constant(part.size_m.x()));
    case geometry::UrdfSolid::Mesh:
      break;
  }
  const Result<fs::path> file = robot_file(part.file, folders);
  if (!file) return bad_input(fmt::format("'{}': {}", geometry::shown_text(part.file, 200), file.error().message));
  Result<TriangleMesh> mesh = read_mesh(file.value(), {});
  if (!mesh) return mesh;
  for (Vec3& v : mesh.value().vertices_m) v = v.cwiseProduct(part.scale);
  // A mirrored mesh would be inside out.
  if (part.scale.prod() < 0)
    for (auto& triangle : mesh.value().triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

}  // namespace

Result<fs::path> robot_file(const std::string& name, const RobotFolders& folders) {
  for (const std::string_view scheme : {"package://", "model://"})
    if (name.starts_with(scheme)) return in_package(name.substr(scheme.size()), folders);
  if (name.starts_with("file://")) return fs::path(name.substr(7));
  if (name.find("://") != std::string::npos) return bad_input("must be a path, file://, package:// or model://");
  return fs::path(name).is_absolute() ? fs::path(name) : folders.folder / name;
}

Result<TriangleMesh> mesh_of_link(const geometry::UrdfLink& link, const RobotFolders& folders) {
  TriangleMesh all;
  for (const geometry::UrdfPart& part : link.parts) {
    const Result<TriangleMesh> mesh = mesh_of_part(part, folders);
    if (!mesh)
      return bad_input(
          fmt::format("line {}: link '{}': {}", part.line, geometry::shown_text(link.name, 80), mesh.error().message));
    const auto base = static_cast<std::uint32_t>(all.vertices_m.size());
    for (const Vec3& v : mesh.value().vertices_m) all.vertices_m.emplace_back(part.rotation * v + part.position_m);
    for (const auto& t : mesh.value().triangles) all.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
  return all;
}

}  // namespace poise::app
