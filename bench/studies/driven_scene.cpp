// SPDX-License-Identifier: MIT
#include "studies/driven_scene.h"

#include <algorithm>
#include <random>
#include <variant>

namespace poise::app {
namespace {

// Number of frames in which each body is shaken once. Chosen.
constexpr std::uint64_t kShakeEach = 16;
// Gap below a body that is poured in, in radii of its bounding sphere. Chosen: bodies fall a little and not deep.
constexpr double kPourGap = 0.25;

Vec3 random_direction(std::mt19937_64& random) {
  // The engine's numbers are the same everywhere; those of the distributions of the standard library are not.
  const auto coordinate = [&] { return static_cast<double>(random() >> 11U) * 0x1p-52 - 1; };
  for (;;) {
    const double x = coordinate();
    const double y = coordinate();
    const Vec3 direction(x, y, coordinate());
    const double length = direction.norm();
    if (length > 0.1 && length <= 1) return direction / length;
  }
}

}  // namespace

Result<DrivenScene> DrivenScene::create(const Scene& scene, const SceneRunOptions& options, std::uint64_t most,
                                        std::uint64_t present, const Shake& shake) {
  for (const SceneGenerator& generator : scene.generators) {
    if (std::holds_alternative<StreamGenerator>(generator))
      return bad_input(scene.source + ": has a stream, so its population changes by itself and cannot be driven");
  }
  SceneRunOptions start = options;
  start.bodies = most;
  Result<SceneRun> run = SceneRun::create(scene, start);
  if (!run) return run.error();
  DrivenScene made(scene, std::move(run).value(), shake);
  Status done = made.list_generated(most, options.seed.value_or(scene.seed));
  if (done) done = made.set_population(std::min<std::uint64_t>(present, made.generated_.size()));
  if (!done) return done.error();
  return made;
}

Status DrivenScene::list_generated(std::uint64_t most, std::uint64_t seed) {
  std::vector<double> radius_m;
  for (const ShapePtr& shape : run_.shapes()) radius_m.push_back(shape->bounding_radius_m);
  io::ExpandOptions expand;
  expand.bodies = most;
  expand.seed = seed;
  expand.radius_m = std::span(radius_m).first(scene_->shapes.size());
  expand.tray_side_m = run_.tray_side_m();
  Result<std::vector<io::GeneratedBody>> generated = io::expand_generators(*scene_, expand);
  if (!generated) return generated.error();
  generated_ = std::move(generated).value();
  for (const io::GeneratedBody& body : generated_)
    highest_m_ = std::max(highest_m_, -down().dot(body.center_m) + run_.shapes()[body.shape]->bounding_radius_m);
  // They are the last bodies of the run.
  for (const RunBody& body : run_.bodies().last(generated_.size())) present_.push_back(body.id);
  for (std::size_t i = 0; i < scene_->shapes.size(); ++i) shapes_.push_back(run_.world().add_shape(run_.shapes()[i]));
  for (const SceneMaterial& material : scene_->materials) {
    const Result<MaterialId> id = run_.world().add_material(material.material);
    if (!id) return id.error();
    materials_.push_back(id.value());
  }
  return Done{};
}

Status DrivenScene::set_population(std::uint64_t bodies) {
  // To change bodies would end the step.
  if (run_.world().step_unfinished()) return Done{};
  while (present_.size() > bodies) {
    const Status removed = run_.world().remove_body(present_.back());
    if (!removed) return removed;
    present_.pop_back();
  }
  while (present_.size() < std::min<std::uint64_t>(bodies, generated_.size())) {
    const Result<bool> poured = pour(generated_[present_.size()]);
    if (!poured) return poured.error();
    if (!poured.value()) break;
  }
  return Done{};
}

Vec3 DrivenScene::down() const {
  return scene_->gravity_mps2.isZero() ? Vec3::UnitX() : scene_->gravity_mps2.normalized();
}

Result<bool> DrivenScene::pour(const io::GeneratedBody& body) {
  const Shape& shape = *run_.shapes()[body.shape];
  const bool falls = !scene_->gravity_mps2.isZero();
  SphereCast cast;
  cast.center_m = body.center_m;
  cast.radius_m = shape.bounding_radius_m;
  cast.direction = down();
  if (!falls) cast.max_distance_m = 0;
  Result<std::optional<SphereCastHit>> hit = run_.world().cast_sphere(cast);
  if (falls && hit && hit.value() && hit.value()->overlaps_at_start) {
    // A heap has risen to its place: from above all places.
    cast.center_m -= (highest_m_ + cast.radius_m + cast.direction.dot(body.center_m)) * cast.direction;
    hit = run_.world().cast_sphere(cast);
  }
  if (!hit) return hit.error();
  Vec3 center_m = cast.center_m;
  if (hit.value()) {
    if (hit.value()->overlaps_at_start) return false;
    center_m += std::max(0.0, hit.value()->distance_m - kPourGap * shape.bounding_radius_m) * cast.direction;
  }
  BodyDefinition definition;
  definition.shape = shapes_[body.shape];
  definition.material = materials_[body.kind->material];
  definition.position_m = center_m - body.orientation * shape.origin_offset_m;
  definition.orientation = body.orientation;
  definition.velocity_mps = body.velocity_mps;
  definition.angular_velocity_radps = body.angular_velocity_radps;
  definition.group = body.kind->group;
  definition.collides_with = body.kind->collides_with;
  definition.importance = body.kind->importance;
  const Result<BodyId> added = run_.world().add_body(definition);
  if (!added) return added.error();
  present_.push_back(added.value());
  return true;
}

Status DrivenScene::shake_bodies() {
  if (shake_.speed_mps <= 0 || run_.world().step_unfinished()) return Done{};
  std::mt19937_64 random(frame_);
  for (std::size_t i = frame_ % kShakeEach; i < present_.size(); i += kShakeEach) {
    const Result<BodyState> state = run_.world().state(present_[i]);
    if (!state) return state.error();
    const Vec3 change_mps = shake_.speed_mps * random_direction(random);
    const Status set = run_.world().set_velocity(present_[i], state.value().velocity_mps + change_mps,
                                                 state.value().angular_velocity_radps);
    if (!set) return set;
  }
  return Done{};
}

Result<StepInput> DrivenScene::begin_frame() {
  // Where the camera is; a driven scene has no streams.
  const Status ready = run_.before_frame(frame_);
  if (!ready) return ready.error();
  const Status shaken = shake_bodies();
  if (!shaken) return shaken.error();
  StepInput input;
  input.dt_s = scene_->dt_s;
  input.view = run_.view();
  input.max_level = scene_->max_level;
  input.polygons = scene_->polygons;
  input.backtracking = scene_->backtracking;
  return input;
}

Result<FrameReport> DrivenScene::end_frame(const StepInput& input) {
  FrameReport report = run_.world().step(input);
  if (report.status != StepStatus::Done) return bad_input("the step was refused: its input is out of range");
  ++frame_;
  return report;
}

Result<simulation::RunFrame> DrivenScene::step(const FrameLimit& limit, bool reference) {
  Result<StepInput> input = begin_frame();
  if (!input) return input.error();
  input.value().measure_energy = true;
  input.value().reference = reference;
  if (limit.work_units) input.value().budget = Budget::work(*limit.work_units);
  if (limit.deadline) input.value().budget = Budget::within(*limit.deadline);
  input.value().may_slice = limit.may_slice && run_.world().settings().islands_wait == IslandsWait::Any;
  Result<FrameReport> report = end_frame(input.value());
  if (!report) return report.error();
  simulation::RunFrame frame;
  frame.report = std::move(report).value();
  return frame;
}

}  // namespace poise::app
