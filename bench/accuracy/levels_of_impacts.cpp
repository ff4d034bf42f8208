// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "accuracy/impacts.h"
#include "accuracy/small_world.h"
#include "poise/assets/mesh_file.h"
#include "poise/assets/tree_cache.h"

namespace poise::accuracy {
namespace {

constexpr std::array<const char*, 4> kMeshes = {"jack", "torus", "l", "bowl"};
constexpr Level kDepth = 3;
constexpr double kStepS = 1.0 / 120;
constexpr int kFrames = 150;

// The bodies of a cloud begin apart and part again. Bounds of the frames in which none meets: a fifth above the most
// that was measured at any level (docs/accuracy.md, "Bounds that were measured").
struct Cloud {
  double restitution, friction, frames_apart;
};
constexpr std::array<Cloud, 3> kClouds = {{{0, 0, 46}, {1, 0, 104}, {0.3, 0.5, 48}}};

std::string level_name(Level level) { return level > kDepth ? "polygons" : fmt::format("level {}", level); }

// Level kDepth + 1 means polygons.
void set_level(SmallWorld& world, Level level) {
  world.input.max_level = level;
  world.input.polygons = level > kDepth;
  if (level > kDepth) world.input.max_level = kMaxTreeDepth;
}

Result<std::vector<ShapePtr>> load(const Context& context) {
  std::vector<ShapePtr> shapes;
  for (const char* name : kMeshes) {
    const Result<TriangleMesh> mesh = read_mesh(context.scenes / "meshes" / fmt::format("{}.obj", name), {});
    if (!mesh) return mesh.error();
    TreeBuildOptions build;
    build.depth = kDepth;
    build.threads = context.threads;
    build.stop = context.stop;
    const TreeCacheSettings off{.on = false, .folder = {}};
    const Result<SphereTree> tree = cached_sphere_tree(mesh.value(), build, context.tree_cache.value_or(off));
    if (!tree) return tree.error();
    const Result<ShapePtr> shape = make_mesh_shape_with_tree(mesh.value(), tree.value());
    if (!shape) return shape.error();
    shapes.push_back(shape.value());
  }
  return shapes;
}

struct Watched {
  double momentum = 0, angular_momentum = 0, energy = 0;  // largest change as a share of the possible sum
  int frames_without_impulse = 0;
};

Watched watch(SmallWorld& world, int frames) {
  const Motions start = motions_of(world.world(), world.bodies());
  Watched watched;
  for (int i = 0; i < frames; ++i) {
    world.step(kStepS);
    const bool impulse = std::ranges::any_of(
        world.world().contacts(), [](const Contact& contact) { return contact.impulse_ns.squaredNorm() > 0; });
    if (!impulse) ++watched.frames_without_impulse;
    const Motions now = motions_of(world.world(), world.bodies());
    watched.momentum =
        std::max(watched.momentum, (now.momentum_ns - start.momentum_ns).norm() / start.scale.momentum_ns);
    watched.angular_momentum =
        std::max(watched.angular_momentum,
                 (now.angular_momentum_js - start.angular_momentum_js).norm() / start.scale.angular_momentum_js);
    watched.energy = std::max(watched.energy, std::abs(now.kinetic_j / start.kinetic_j - 1));
  }
  return watched;
}

// 64 bodies fall toward their common centre.
void fill_cloud(SmallWorld& world, const std::vector<ShapePtr>& shapes) {
  Random random(21);
  std::vector<ShapeId> ids;
  for (const ShapePtr& shape : shapes) ids.push_back(world.shape(shape));
  for (int i = 0; i < 64; ++i) {
    const Vec3 place = 1.5 * Vec3(i % 4 - 1.5, i / 4 % 4 - 1.5, i / 16 - 1.5);
    world.add(ids[static_cast<std::size_t>(i) % ids.size()], place, -1.2 * place + random.in_box(0.5), random.turn(),
              random.in_box(3));
  }
}

}  // namespace

Status cloud_momenta(Context& context) {
  const Result<std::vector<ShapePtr>> shapes = load(context);
  if (!shapes) return shapes.error();
  double done = 0;
  for (const auto& [e, friction, frames_apart] : kClouds) {
    for (Level level = 0; level <= kDepth + 1; ++level) {
      SmallWorld world(context, Vec3::Zero(), {e, friction, 1000});
      fill_cloud(world, shapes.value());
      set_level(world, level);
      const Watched watched = watch(world, kFrames);
      const std::string which =
          fmt::format("{}, e = {:g}{}", level_name(level), e, friction > 0 ? ", friction 0.5" : "");
      context.add("change of momentum, " + which, "1", watched.momentum, 1e-12);
      context.add("change of angular momentum, " + which, "1", watched.angular_momentum, 1e-12);
      context.add("frames without an impulse, " + which, "", watched.frames_without_impulse, frames_apart);
      const Status go_on = context.at(++done / 15);
      if (!go_on) return go_on;
    }
  }
  return Done{};
}

Status impact_energy(Context& context) {
  const Result<std::vector<ShapePtr>> shapes = load(context);
  if (!shapes) return shapes.error();
  for (Level level = 0; level <= kDepth + 1; ++level) {
    double worst = 0;
    int without_impulse = 0;
    Random random(31);
    for (int k = 0; k < 24; ++k) {
      // A single pair with an eccentric impact; it separates after one or a few impacts.
      SmallWorld world(context, Vec3::Zero(), {1, 0, 1000});
      const ShapeId a = world.shape(shapes.value()[static_cast<std::size_t>(k) % kMeshes.size()]);
      const ShapeId b = world.shape(shapes.value()[static_cast<std::size_t>(k / 4) % kMeshes.size()]);
      const Vec3 line = random.direction();
      world.add(a, Vec3::Zero(), Vec3::Zero(), random.turn(), random.in_box(2));
      world.add(b, 2.2 * line + random.in_box(0.15), -2 * line, random.turn(), random.in_box(2));
      set_level(world, level);
      const Watched watched = watch(world, kFrames);
      worst = std::max(worst, watched.energy);
      if (watched.frames_without_impulse == kFrames) ++without_impulse;
    }
    context.add("change of kinetic energy, " + level_name(level), "1", worst, 1e-12);
    context.add("throws without an impulse, " + level_name(level), "", without_impulse, 0);
    const Status go_on = context.at((level + 1.0) / (kDepth + 2));
    if (!go_on) return go_on;
  }
  return Done{};
}

}  // namespace poise::accuracy
