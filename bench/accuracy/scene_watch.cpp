// SPDX-License-Identifier: MIT
#include "accuracy/scene_watch.h"

#include <algorithm>
#include <cmath>

namespace poise::accuracy {

SceneWatch::SceneWatch(Scene scene, SceneRun run) : scene_(std::move(scene)), run_(std::move(run)) {
  for (const RunBody& body : run_.bodies()) {
    if (body.motion == MotionType::Dynamic) bodies_.push_back(body.id);
  }
  input.dt_s = scene_.dt_s;
  input.max_level = scene_.max_level;
  input.polygons = scene_.polygons;
  remember();
}

Result<SceneWatch> SceneWatch::start(const Context& context, const std::string& file,
                                     const std::function<void(Scene&)>& change, std::optional<std::uint64_t> bodies,
                                     std::uint64_t seeds_on) {
  Result<Scene> scene = read_scene(context.scenes / file);
  if (!scene) return scene.error();
  if (change) change(scene.value());
  SceneRunOptions options;
  options.world = context.world_settings();
  options.world.policy = scene.value().policy;
  options.bodies = bodies;
  if (seeds_on > 0) options.seed = scene.value().seed + seeds_on;
  options.tree_cache = context.tree_cache;
  Result<SceneRun> run = SceneRun::create(scene.value(), options);
  if (!run) return run.error();
  return SceneWatch(std::move(scene).value(), std::move(run).value());
}

FrameReport SceneWatch::step() {
  const Status due = run_.before_frame(frame_++);
  FrameReport report;
  if (due) report = run_.world().step(input);
  return report;
}

BodyState SceneWatch::at(BodyId body) const { return run_.world().state(body).value(); }

void SceneWatch::remember() {
  then_.clear();
  for (const BodyId body : bodies_) then_.push_back(at(body).position_m);
}

double SceneWatch::drift_m() const {
  double drift = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const double moved = (at(bodies_[i]).position_m - then_[i]).norm();
    drift = std::isfinite(moved) ? std::max(drift, moved) : HUGE_VAL;
  }
  return drift;
}

std::size_t SceneWatch::fallen() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const double size_m = 2 * run_.world().shape(bodies_[i]).value()->bounding_radius_m;
    count += at(bodies_[i]).position_m.z() > then_[i].z() - 0.1 * size_m ? 0U : 1U;
  }
  return count;
}

double SceneWatch::kinetic_j() const { return run_.world().conserved().kinetic_j; }

double SceneWatch::energy_j() const {
  const Conserved sums = run_.world().conserved();
  return sums.kinetic_j + sums.potential_j;
}

double SceneWatch::largest_speed_mps() const {
  double largest = 0;
  for (const BodyId body : bodies_) {
    const double speed = at(body).velocity_mps.norm();
    largest = std::isfinite(speed) ? std::max(largest, speed) : HUGE_VAL;
  }
  return largest;
}

double SceneWatch::mean_height_m() const {
  double sum = 0;
  for (const BodyId body : bodies_) sum += at(body).position_m.z();
  return sum / static_cast<double>(bodies_.size());
}

double SceneWatch::weight_scale_j() const {
  double sum = 0;
  for (const BodyId body : bodies_) {
    sum += run_.world().mass_kg(body).value() * scene_.gravity_mps2.norm() *
           run_.world().shape(body).value()->bounding_radius_m;
  }
  return sum;
}

std::size_t SceneWatch::outside() const {
  std::size_t count = 0;
  const double half_m = run_.tray_side_m() > 0 ? 0.5 * run_.tray_side_m() : HUGE_VAL;
  for (const BodyId body : bodies_) {
    const Vec3 place = at(body).position_m;
    count +=
        std::abs(place.x()) <= half_m && std::abs(place.y()) <= half_m && place.z() >= 0 && place.z() < 1e6 ? 0U : 1U;
  }
  return count;
}

std::uint64_t SceneWatch::frames_of(double seconds) const {
  return static_cast<std::uint64_t>(std::llround(seconds / scene_.dt_s));
}

}  // namespace poise::accuracy
