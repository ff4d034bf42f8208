// SPDX-License-Identifier: MIT
#include <memory>

#include "bad_input/box_mesh.h"
#include "bad_input/trial.h"
#include "poise/world.h"
#include "scene/made_by.h"

namespace poise::bench {
namespace {

struct PoiseTrial {
  explicit PoiseTrial(World made) : world(std::move(made)) {}
  World world;
  MaterialId material;
  std::vector<BodyId> bodies;

  Status add(const Result<ShapePtr>& shape, const TrialBody& body, MotionType motion = MotionType::Dynamic) {
    if (!shape) return shape.error();
    BodyDefinition definition;
    definition.shape = world.add_shape(shape.value());
    definition.material = material;
    definition.motion = motion;
    definition.position_m = body.position_m;
    definition.orientation = body.orientation;
    definition.mass_kg = body.mass_kg;
    const Result<BodyId> id = world.add_body(definition);
    if (!id) return id.error();
    if (motion == MotionType::Dynamic) bodies.push_back(id.value());
    return Done{};
  }
};

TriangleMesh mesh_of(const std::array<Vec3, 8>& corners, bool inside_out) {
  TriangleMesh mesh;
  mesh.vertices_m.assign(corners.begin(), corners.end());
  for (const auto& [a, b, c] : kBoxTriangles) mesh.triangles.push_back({a, inside_out ? c : b, inside_out ? b : c});
  return mesh;
}

Result<ShapePtr> shape_of(const TriangleMesh& mesh) { return make_mesh_shape(mesh, {.depth = 3}); }

}  // namespace

TrialEngine trial_of_poise(Ground ground) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = ExecutorKind::Serial;
  const auto trial = std::make_shared<PoiseTrial>(World::create(settings).value());
  trial->material = trial->world.add_material({0, 0.5, 1000}).value();
  const Result<ShapePtr> floor = ground == Ground::Plane
                                     ? make_plane_shape(Vec3::UnitZ(), 0)
                                     : shape_of(mesh_of(box_corners(Vec3(4, 4, 1), Vec3(0, 0, -1)), true));
  const Status grounded = trial->add(floor, {}, MotionType::Static);
  TrialEngine engine;
  engine.version = "Poise " + io::this_build().version;
  engine.add = [trial, grounded](const TrialBody& body) -> Status {
    if (!grounded) return grounded;
    return trial->add(
        body.box ? shape_of(mesh_of(box_corners(Vec3::Constant(0.25), Vec3::Zero()), false)) : make_sphere_shape(0.25),
        body);
  };
  engine.add_degenerate = [trial] {
    std::array<Vec3, 8> same;
    same.fill(Vec3(0, 0, 0));
    return trial->add(shape_of(mesh_of(same, false)), {1, Vec3(0, 0, 2)});
  };
  engine.set_velocity = [trial](std::size_t body, const Vec3& velocity_mps) {
    return trial->world.set_velocity(trial->bodies[body], velocity_mps, Vec3::Zero());
  };
  engine.step = [trial](double dt_s) -> Status {
    StepInput input;
    input.dt_s = dt_s;
    if (trial->world.step(input).status == StepStatus::Done) return Done{};
    return bad_input("StepStatus::RefusedTimeStep");
  };
  engine.positions_m = [trial] {
    std::vector<Vec3> positions;
    for (const BodyId body : trial->bodies) positions.push_back(trial->world.state(body).value().position_m);
    return positions;
  };
  return engine;
}

}  // namespace poise::bench
