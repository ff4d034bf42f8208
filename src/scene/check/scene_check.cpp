// SPDX-License-Identifier: MIT
#include "scene/check/scene_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "assets/json/json_document.h"
#include "parallel/executor.h"
#include "scene/check/admission.h"
#include "scene/check/placed_bodies.h"
#include "scene/scene_memory.h"
#include "scene/scene_parse.h"
#include "scene/scene_shapes.h"

namespace poise::io {
namespace {

/// Most bodies that are checked for overlaps and view. Chosen: takes a second.
constexpr std::size_t kMostLookedAt = 200'000;
constexpr std::size_t kMostPairs = 1000;

// For the origin of the estimates see docs/scene-format.md, "What a scene needs".
constexpr double kBytesOfNode = 60;
constexpr double kBytesOfTriangle = 300;
constexpr double kBodyNs = 3500;  ///< mandatory work of a frame for a body in a pile, processor time
constexpr double kExpansionNs = 35;
constexpr double kTriangleNs = 100;  ///< for a leaf that is refined to its triangles

/// Nodes of a full tree of this depth.
double nodes_of_depth(Level depth) { return (std::pow(8.0, depth + 1) - 1) / 7; }

/// docs/sphere-trees.md, "Time and memory against triangles", default preset; deeper trees have more cells.
double build_cpu_s(std::uint64_t triangles, Level depth) {
  const double of_depth_3 = 3 + 0.024 * std::sqrt(static_cast<double>(triangles));
  const double cells = std::clamp(24 * std::pow(8.0, depth), 56'000.0, 600'000.0);
  return of_depth_3 * cells / 56'000;
}

std::string mm_or_m(double length_m) {
  return length_m < 0.1 ? fmt::format("{:.3g} mm", 1000 * length_m) : fmt::format("{:.3g} m", length_m);
}

/// The check of one scene. Invariant: while there is no error, shapes_ is as long as the scene's list.
class Checker {
 public:
  Checker(const Scene& scene, const SceneCheckOptions& options, SceneCheck& check)
      : scene_(scene), options_(options), check_(check) {}

  void shapes();
  void bodies();
  void needs();
  void tray();
  void overlaps();
  void upside();
  void view();
  void time_step();
  void fit();

 private:
  void warn(const std::string& path, const std::string& what) {
    check_.warnings.push_back(fmt::format("{}: {}: {}", scene_.source, path, what));
  }
  void add_shape(const SceneShape& source);
  void add_mesh(const MeshSource& source, const std::string& place, CheckedShape& shape);
  void add_tray_planes();
  [[nodiscard]] std::string path_of_shape(std::size_t shape) const {
    return member_path("shapes", scene_.shapes[shape].name);
  }

  const Scene& scene_;
  const SceneCheckOptions& options_;
  SceneCheck& check_;
  std::vector<CheckedShape> shapes_;
  std::vector<PlacedBody> bodies_;
  double tray_side_m_ = 0;
};

void Checker::add_mesh(const MeshSource& source, const std::string& place, CheckedShape& shape) {
  const Result<TriangleMesh> mesh = scene_mesh(scene_, source);
  if (!mesh) {
    check_.errors.push_back(place + ": " + mesh.error().message);
    return;
  }
  shape.triangles = mesh.value().triangles.size();
  if (!shape.shape) {
    // Building the root alone takes almost no time; it is refused in the same cases as the whole tree, and gives mass
    // and size.
    TreeBuildOptions root;
    root.depth = 0;
    root.preset = TreePreset::Fast;
    root.threads = options_.threads;
    Result<ShapePtr> made = make_mesh_shape(mesh.value(), root, source.shell_thickness_m);
    if (!made) {
      check_.errors.push_back(place + ": " + made.error().message);
      return;
    }
    shape.shape = std::move(made).value();
    shape.to_build = true;
    check_.tree_cpu_s += build_cpu_s(shape.triangles, source.depth);
    ++check_.trees_to_build;
  } else {
    ++check_.trees_ready;
  }
  std::vector<Sphere> corners;
  for (const Vec3& vertex : mesh.value().vertices_m) corners.push_back({vertex - shape.shape->origin_offset_m, 0});
  shape.outline = outline_of(corners);
}

void Checker::add_shape(const SceneShape& source) {
  CheckedShape shape;
  const std::string place = place_of(scene_, source);
  Result<ShapePtr> loaded = load_without_building(scene_, source, {options_.threads, options_.tree_cache});
  const auto* mesh = std::get_if<MeshSource>(&source.source);
  const bool missing = !loaded && mesh != nullptr && loaded.error().kind == ErrorKind::Cancelled;
  if (!loaded && !missing) {
    check_.errors.push_back(place + ": " + loaded.error().message);
    return;
  }
  if (loaded) shape.shape = std::move(loaded).value();
  if (mesh != nullptr) add_mesh(*mesh, place, shape);
  if (!shape.shape) return;
  const SphereTree& tree = shape.shape->tree;
  if (mesh == nullptr && shape.shape->kind == ShapeKind::Tree) {
    std::vector<Sphere> leaves;
    for (std::size_t i = 0; i < tree.node_count(); ++i) {
      if (tree.child_count[i] == 0)
        leaves.push_back({Eigen::Vector3f(tree.x_m[i], tree.y_m[i], tree.z_m[i]).cast<double>(),
                          static_cast<double>(tree.radius_m[i])});
    }
    shape.outline = outline_of(leaves);
  }
  for (int axis = 0; axis < 3; ++axis) {
    double least = 0, most = 0;
    for (const Sphere& part : shape.outline) {
      least = std::min(least, part.center_m[axis] - part.radius_m);
      most = std::max(most, part.center_m[axis] + part.radius_m);
    }
    shape.size_m[axis] = most - least;
  }
  if (!shape.shape->note.empty()) check_.warnings.push_back(place + ": " + shape.shape->note);
  shapes_.push_back(std::move(shape));
}

void Checker::shapes() {
  for (const SceneShape& source : scene_.shapes) add_shape(source);
}

void Checker::add_tray_planes() {
  const double half_m = 0.5 * tray_side_m_;
  const std::pair<Vec3, double> planes[] = {{Vec3::UnitZ(), 0},
                                            {Vec3::UnitX(), -half_m},
                                            {-Vec3::UnitX(), -half_m},
                                            {Vec3::UnitY(), -half_m},
                                            {-Vec3::UnitY(), -half_m}};
  for (const auto& [normal, offset_m] : planes) {
    CheckedShape wall;
    Result<ShapePtr> made = make_plane_shape(normal, offset_m);
    if (!made) {
      check_.errors.push_back(
          fmt::format("{}: tray: a side of {:g} m: {}", scene_.source, tray_side_m_, made.error().message));
      return;
    }
    wall.shape = std::move(made).value();
    shapes_.push_back(wall);
    PlacedBody body;
    body.path = "tray";
    body.shape = shapes_.size() - 1;
    body.is_static = body.plane = true;
    bodies_.push_back(body);
  }
}

void Checker::bodies() {
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    const SceneBody& body = scene_.bodies[i];
    const BodyDefinition& d = body.definition;
    const Shape& shape = *shapes_[body.shape].shape;
    PlacedBody placed{item_path("bodies", i), body.shape, d.position_m, d.orientation, d.velocity_mps};
    placed.plane = shape.kind == ShapeKind::Plane;
    if (!placed.plane) placed.center_m += d.orientation * shape.origin_offset_m;
    placed.radius_m = shape.bounding_radius_m;
    placed.group = d.group;
    placed.collides_with = d.collides_with;
    placed.is_static = d.motion != MotionType::Dynamic;
    bodies_.push_back(std::move(placed));
  }
  std::vector<double> radius_m;
  for (const CheckedShape& shape : shapes_) radius_m.push_back(shape.shape->bounding_radius_m);
  tray_side_m_ = tray_side_m(scene_, options_.bodies.value_or(generated_body_count(scene_)), radius_m);
  if (options_.max_memory_bytes) {
    const Result<std::uint32_t> pairs = pairs_that_fit(scene_, options_.bodies, options_.threads,
                                                       *options_.max_memory_bytes, WorldSettings{}.max_pairs);
    if (!pairs) {
      check_.errors.push_back(pairs.error().message);
      return;
    }
  }
  ExpandOptions expand;
  expand.bodies = options_.bodies;
  expand.seed = options_.seed.value_or(scene_.seed);
  expand.radius_m = radius_m;
  expand.tray_side_m = tray_side_m_;
  const Result<std::vector<GeneratedBody>> made = expand_generators(scene_, expand);
  if (!made) {
    check_.errors.push_back(made.error().message);
    return;
  }
  check_.errors = refused_by_world(scene_, shapes_, made.value(), kMostLookedAt);
  if (scene_.tray) add_tray_planes();
  if (!check_.errors.empty()) return;
  const std::uint64_t most = most_at_once(made.value());
  check_.bodies = bodies_.size() + most;
  for (const PlacedBody& body : bodies_) check_.dynamic_bodies += body.is_static ? 0 : 1;
  check_.dynamic_bodies += most;
  for (const GeneratedBody& body : made.value()) check_.dynamic_bodies -= body.is_static ? 1 : 0;
  for (const GeneratedBody& body : made.value()) {
    if (bodies_.size() >= kMostLookedAt) break;
    PlacedBody placed{"generators", body.shape, body.center_m, body.orientation, body.velocity_mps};
    placed.radius_m = shapes_[body.shape].shape->bounding_radius_m;
    placed.group = body.kind->group;
    placed.collides_with = body.kind->collides_with;
    placed.is_static = body.is_static;
    placed.streamed = body.streamed;
    bodies_.push_back(std::move(placed));
  }
}

void Checker::needs() {
  double trees_bytes = 0;
  double leaves_cost_ns = 0;
  const double growth = scene_.policy.front_growth;
  for (std::size_t i = 0; i < scene_.shapes.size(); ++i) {
    const CheckedShape& shape = shapes_[i];
    const auto* mesh = std::get_if<MeshSource>(&scene_.shapes[i].source);
    const Level depth = shape.to_build ? mesh->depth : shape.shape->tree.depth();
    const double nodes = shape.to_build ? nodes_of_depth(depth) : static_cast<double>(shape.shape->tree.node_count());
    trees_bytes += kBytesOfNode * nodes + kBytesOfTriangle * static_cast<double>(shape.triangles);
    if (shape.to_build) trees_bytes += 25e6 + 700 * static_cast<double>(shape.triangles);
    const Level deepest = std::min(depth, scene_.max_level);
    double entries = 1, cost_ns = kExpansionNs;
    for (Level level = 0; level < deepest; ++level) cost_ns += kExpansionNs * (entries *= growth);
    if (scene_.polygons && shape.triangles > 0)
      cost_ns += kTriangleNs * entries * growth * std::max(1.0, 8 * static_cast<double>(shape.triangles) / nodes);
    leaves_cost_ns = std::max(leaves_cost_ns, cost_ns);
  }
  const int processors = parallel::available_threads();
  check_.threads = options_.threads > 0 ? options_.threads : processors;
  const int useful = std::min(check_.threads, processors);
  check_.tree_wall_s = check_.tree_cpu_s / useful;
  BodyNumbers numbers = body_numbers(scene_, options_.bodies);
  numbers.at_once = static_cast<double>(check_.bodies);
  check_.memory_bytes = bodies_bytes(numbers, check_.threads) + trees_bytes;
  check_.heap_frame_ms = 1e-6 * kBodyNs * static_cast<double>(check_.dynamic_bodies) / useful;
  check_.pair_ms = 1e-6 * leaves_cost_ns;
  check_.deadline_ms = scene_.deadline_ms.value_or(1000 * scene_.dt_s);
  const char* field = scene_.deadline_ms ? "deadline_ms" : "dt_s";
  if (check_.heap_frame_ms > check_.deadline_ms) {
    warn(field, fmt::format("a frame has {:.3g} ms; {} bodies in a heap take about {:.3g} ms on {} threads before "
                            "anything is refined",
                            check_.deadline_ms, check_.dynamic_bodies, check_.heap_frame_ms, useful));
  } else if (check_.pair_ms > check_.deadline_ms) {
    warn(field, fmt::format("a frame has {:.3g} ms; refining one pair of its shapes to the end takes about {:.3g} ms",
                            check_.deadline_ms, check_.pair_ms));
  }
}

void Checker::tray() {
  if (!scene_.tray) return;
  if (scene_.gravity_mps2.isZero(0)) {
    warn("gravity_mps2", "is zero, and the scene has a tray: nothing falls into it");
  } else if (scene_.gravity_mps2.z() >= 0) {
    warn("gravity_mps2", "does not point down (-z), and the scene has a tray with its floor at z = 0");
  }
  std::vector<bool> used(scene_.shapes.size());
  for (const PlacedBody& body : bodies_) {
    if (!body.is_static) used[body.shape] = true;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    const double size_m = shapes_[i].size_m.maxCoeff();
    if (used[i] && size_m > tray_side_m_)
      warn(path_of_shape(i),
           fmt::format("is {} long, larger than the tray, whose side is {}", mm_or_m(size_m), mm_or_m(tray_side_m_)));
  }
}

void Checker::overlaps() {
  std::size_t sunk = 0, deep = 0;
  std::string first_sunk, first_deep;
  for (const DeepPair& pair : deep_pairs(bodies_, shapes_, kMostPairs)) {
    const PlacedBody& a = bodies_[pair.a];
    const PlacedBody& b = bodies_[pair.b];
    const auto named = [this](const PlacedBody& body) {
      const std::string name = body.plane && body.path == "tray" ? "" : scene_.shapes[body.shape].name;
      return name.empty() ? body.path : fmt::format("{} ({})", body.path, printable(name));
    };
    const std::string text = fmt::format("{} and {}, {} deep", named(a), named(b), mm_or_m(pair.depth_m));
    if ((b.plane ? sunk : deep)++ == 0) (b.plane ? first_sunk : first_deep) = text;
  }
  const auto how_many = [](std::size_t pairs, const char* what) {
    return pairs == 1 ? fmt::format("a {}", what)
                      : fmt::format("{}{} {}s", pairs >= kMostPairs ? "at least " : "", pairs, what);
  };
  if (sunk > 0)
    warn("bodies",
         fmt::format("below a floor or in a wall at the start: {}, first {}", how_many(sunk, "body"), first_sunk));
  if (deep > 0)
    warn("bodies", fmt::format("start deep in one another: {}, first {}", how_many(deep, "pair"), first_deep));
}

void Checker::upside() {
  if (scene_.gravity_mps2.isZero(0)) return;
  const Vec3 upward = -scene_.gravity_mps2.normalized();
  for (std::size_t i = 0; i < scene_.shapes.size(); ++i) {
    const auto* mesh = std::get_if<MeshSource>(&scene_.shapes[i].source);
    if (mesh == nullptr || mesh->turned) continue;
    const std::string ending = mesh->file.extension().string();
    if (ending != ".gltf" && ending != ".glb") continue;
    const auto lies = [&](const PlacedBody& body) {
      return body.shape == i && !body.plane && (body.orientation * Vec3::UnitY()).dot(upward) < 0.7 &&
             body.orientation.isApprox(Quat::Identity(), 1e-9);
    };
    if (std::any_of(bodies_.begin(), bodies_.end(), lies))
      warn(path_of_shape(i) + ".mesh",
           "glTF files have y upward, so it lies on its back under this gravity; \"up\": \"y\" puts it upright, "
           "\"up\": \"z\" says that it is meant so");
  }
}

void Checker::view() {
  if (!scene_.camera) return;
  const View view = scene_view(scene_);
  const bool moves = check_.dynamic_bodies > 0;
  bool any = false;
  for (const PlacedBody& body : bodies_) {
    if (body.plane || (moves && body.is_static)) continue;
    any = any || in_view(view, body.center_m, body.radius_m);
  }
  if (!any) warn("camera", fmt::format("sees none of the {} at the start", moves ? "moving bodies" : "bodies"));
}

void Checker::time_step() {
  const double dt_s = scene_.dt_s;
  const double fall_m = scene_.gravity_mps2.norm() * dt_s * dt_s;
  std::vector<double> fastest_mps(scene_.shapes.size(), -1);
  for (const PlacedBody& body : bodies_) {
    if (!body.is_static) fastest_mps[body.shape] = std::max(fastest_mps[body.shape], body.velocity_mps.norm());
  }
  for (std::size_t i = 0; i < fastest_mps.size(); ++i) {
    const double half_m = 0.5 * shapes_[i].size_m.minCoeff();
    if (fastest_mps[i] < 0 || !(half_m > 0)) continue;
    if (fall_m > half_m) {
      warn("dt_s", fmt::format("too long for {}: what falls gains {} a step in each step, more than half its least "
                               "extent, {}",
                               path_of_shape(i), mm_or_m(fall_m), mm_or_m(half_m)));
    } else if (!scene_.backtracking && fastest_mps[i] * dt_s > half_m) {
      warn("dt_s", fmt::format("too long for {}: at {:.3g} m/s it moves {} in a step, more than half its least extent, "
                               "{}, and may pass through thin bodies (\"backtracking\": true finds them)",
                               path_of_shape(i), fastest_mps[i], mm_or_m(fastest_mps[i] * dt_s), mm_or_m(half_m)));
    }
  }
}

// How far the surface of a tree's deepest level is from the mesh, on the average of its leaves.
double mean_protrusion_m(const SphereTree& tree) {
  double sum_m = 0, leaves = 0;
  for (std::size_t i = 0; i < tree.node_count(); ++i) {
    if (tree.child_count[i] != 0) continue;
    sum_m += static_cast<double>(tree.protrusion_mean_m[i]);
    ++leaves;
  }
  return leaves > 0 ? sum_m / leaves : 0;
}

// What is wide and thin has spheres far thicker than itself, and what is smaller than these does not lie on it.
void Checker::fit() {
  if (scene_.polygons) return;
  std::vector<bool> used(scene_.shapes.size()), moves(scene_.shapes.size());
  for (const PlacedBody& body : bodies_) {
    if (body.shape >= used.size()) continue;
    used[body.shape] = true;
    if (!body.is_static) moves[body.shape] = true;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    const CheckedShape& shape = shapes_[i];
    if (!used[i] || shape.to_build || shape.shape->kind != ShapeKind::Tree) continue;
    const double mean_m = mean_protrusion_m(shape.shape->tree);
    for (std::size_t k = 0; k < moves.size(); ++k) {
      const double size_m = shapes_[k].size_m.minCoeff();
      if (!moves[k] || k == i || mean_m <= 0.5 * size_m) continue;
      warn(path_of_shape(i),
           fmt::format(
               "its spheres are {} off its surface on the average, more than half of the least extent of {}, {}, which "
               "may sink into it or pass (\"depth\" makes them smaller, \"max_level\": \"polygons\" goes by the "
               "surface)",
               mm_or_m(mean_m), path_of_shape(k), mm_or_m(size_m)));
      break;
    }
  }
}

}  // namespace

SceneCheck check_scene(const Scene& scene, const SceneCheckOptions& options) {
  SceneCheck check;
  if (options.bodies && scene.generators.empty())
    check.errors.push_back(scene.source + ": has no generators, so the number of bodies cannot be chosen");
  if (scene.gaze && scene.gaze->path.empty()) {
    Scene with_gaze;
    with_gaze.source = scene.source;
    with_gaze.base = scene.base;
    with_gaze.camera = scene.camera;
    with_gaze.gaze = scene.gaze;
    const Status read = read_gaze(with_gaze);
    if (!read) check.errors.push_back(read.error().message);
  }
  Checker checker(scene, options, check);
  checker.shapes();
  if (check.errors.empty()) checker.bodies();
  if (!check.errors.empty()) return check;
  checker.needs();
  checker.tray();
  checker.overlaps();
  checker.upside();
  checker.view();
  checker.time_step();
  checker.fit();
  return check;
}

}  // namespace poise::io
