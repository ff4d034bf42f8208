// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>
#include <utility>

#include "peers/engine.h"
#include "scene/made_by.h"

namespace poise::bench {
namespace {

Result<SceneRun> start(const Scene& scene, std::uint64_t bodies, int threads) {
  SceneRunOptions options;
  options.world.threads = threads;
  options.bodies = bodies;
  return SceneRun::create(scene, options);
}

}  // namespace

Result<PileScene> pile_scene(const Scene& scene, std::uint64_t bodies) {
  const auto* const source = scene.shapes.size() == 1 ? std::get_if<SpheresSource>(&scene.shapes[0].source) : nullptr;
  if (source == nullptr || scene.materials.size() != 1 || !scene.tray || !scene.bodies.empty()) {
    return bad_input(scene.source + ": must be generated bodies of one shape of spheres and one material in a tray");
  }
  Result<SceneRun> made = start(scene, bodies, 1);
  if (!made) return made.error();
  const SceneRun& run = made.value();
  const Material& material = scene.materials[0].material;
  const Shape& shape = *run.shapes()[0];
  if (!shape.principal_axes.isApprox(Quat::Identity())) {
    return bad_input(scene.source + ": the principal axes of the shape must be those of its file");
  }
  PileScene pile;
  for (const Sphere& sphere : source->spheres)
    pile.spheres.push_back({sphere.center_m - shape.origin_offset_m, sphere.radius_m});
  pile.mass_kg = shape.volume_m3 * material.density_kgpm3;
  pile.inertia_kgm2 = shape.principal_m5 * material.density_kgpm3;
  for (const RunBody& body : run.bodies()) {
    const Shape& of_body = *run.shapes()[body.shape];
    if (of_body.kind == ShapeKind::Plane) {
      pile.walls.push_back({of_body.plane_normal, of_body.plane_offset_m});
    } else {
      pile.start.push_back(run.world().state(body.id).value());
    }
  }
  pile.friction = material.friction;
  pile.restitution = material.restitution;
  pile.gravity_mps2 = scene.gravity_mps2;
  pile.dt_s = scene.dt_s;
  return pile;
}

Result<Engine> make_poise(const Scene& scene, std::uint64_t bodies, int threads) {
  Result<SceneRun> made = start(scene, bodies, threads);
  if (!made) return made.error();
  auto run = std::make_shared<SceneRun>(std::move(made).value());
  StepInput input;
  input.dt_s = scene.dt_s;
  input.budget = Budget::unlimited();
  input.max_level = scene.max_level;
  Engine engine;
  engine.name = "poise";
  const io::BuildFacts build = io::this_build();
  engine.version = build.version + " " + build.commit + ", double";
  engine.threads = threads;
  engine.step = [run, input] { run->world().step(input); };
  engine.read_states = [run](std::span<BodyState> states) {
    std::size_t next = 0;
    for (const RunBody& body : run->bodies()) {
      if (body.motion == MotionType::Dynamic && next < states.size())
        states[next++] = run->world().state(body.id).value();
    }
  };
  return engine;
}

}  // namespace poise::bench
