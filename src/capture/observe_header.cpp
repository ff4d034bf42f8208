// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/observe.h"
#include "geometry/shape/shape_surface.h"
#include "scene/made_by.h"

namespace poise::capture {
namespace {

CapturedSphere captured(const Sphere& sphere) {
  return {static_cast<float>(sphere.center_m.x()), static_cast<float>(sphere.center_m.y()),
          static_cast<float>(sphere.center_m.z()), static_cast<float>(sphere.radius_m)};
}

std::array<double, 3> array_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

CapturedShape captured(const Shape& shape) {
  CapturedShape made;
  if (shape.kind == ShapeKind::Plane) {
    made.plane = true;
    made.normal = array_of(shape.plane_normal);
    made.offset_m = shape.plane_offset_m;
    return made;
  }
  made.radius_m = shape.bounding_radius_m;
  if (shape.surface) {
    for (const Vec3& vertex : shape.surface->vertices_m) {
      for (const double coordinate : vertex) made.vertices_m.push_back(static_cast<float>(coordinate));
    }
    for (const ShapeSurface::Triangle& triangle : shape.surface->triangles)
      made.corners.insert(made.corners.end(), triangle.vertex.begin(), triangle.vertex.end());
  }
  for (int level = 0; level <= shape.tree.depth(); ++level) {
    std::vector<CapturedSphere>& spheres = made.levels.emplace_back();
    for (const NodeIndex node : shape.tree.nodes_at(static_cast<Level>(level)))
      spheres.push_back(captured(shape.tree.sphere(node)));
  }
  return made;
}

}  // namespace

double position_step_of(const SceneRun& run) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const ShapePtr& shape : run.shapes()) {
    if (shape->kind == ShapeKind::Tree) least_m = std::min(least_m, shape->bounding_radius_m);
  }
  if (!std::isfinite(least_m)) return 1e-3;
  const double ten_m = std::pow(10.0, std::floor(std::log10(least_m / 1000)));
  return std::floor(least_m / 1000 / ten_m * (1 + 1e-9)) * ten_m;
}

std::vector<CapturedShape> captured_shapes(const Scene& scene, const SceneRun& run) {
  static constexpr std::array<const char*, 5> kTrayParts{"floor", "wall -x", "wall +x", "wall -y", "wall +y"};
  std::vector<CapturedShape> shapes;
  for (std::size_t i = 0; i < run.shapes().size(); ++i) {
    shapes.push_back(captured(*run.shapes()[i]));
    const std::size_t of_tray = i - std::min(i, scene.shapes.size());
    shapes.back().name = i < scene.shapes.size()       ? scene.shapes[i].name
                         : of_tray < kTrayParts.size() ? std::string("tray, ") + kTrayParts[of_tray]
                                                       : std::string("tray");
  }
  return shapes;
}

CaptureHeader header_of(const Scene& scene, const SceneRun& run) {
  CaptureHeader header;
  header.scene = scene.name;
  header.build = io::this_build();
  header.machine = io::this_machine();
  header.dt_s = scene.dt_s;
  header.gravity_mps2 = array_of(scene.gravity_mps2);
  header.threads = run.world().threads();
  header.position_step_m = position_step_of(run);
  if (scene.camera) header.camera = CapturedCamera{scene.camera->resolution_px, !scene.camera->path.empty()};
  for (const SceneMaterial& material : scene.materials) {
    header.materials.push_back(
        {material.name, material.material.friction, material.material.restitution, material.material.density_kgpm3});
  }
  header.shapes = captured_shapes(scene, run);
  return header;
}

}  // namespace poise::capture
