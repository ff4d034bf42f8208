// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "accuracy/scene_cases.h"
#include "accuracy/scene_watch.h"

namespace poise::accuracy {
namespace {

constexpr double kSeconds = 60;

/// Requirements on a scene over its 60 s.
struct Standing {
  const char* file;
  double measured_from_s = 0;     ///< drift is measured from this time: 0 for built scenes, later for thrown bodies
  double calm_from_s = 2;         ///< energy must be low from this time on
  std::optional<double> drift_m;  ///< upper limit
  bool thrown = false;            ///< bodies may still shift; none may leave
};

// Number of bodies that have left a bowl: below the rim and outside it, or on the floor.
std::size_t out_of_bowl(const SceneWatch& watch, double rim_radius_m) {
  std::size_t count = 0;
  for (const BodyId body : watch.bodies()) {
    const Vec3 place = watch.at(body).position_m;
    count += std::hypot(place.x(), place.y()) < rim_radius_m && place.z() > 0 ? 0U : 1U;
  }
  return count;
}

Status stand(Context& context, const Standing& standing, double rim_radius_m = 0) {
  Result<SceneWatch> started = SceneWatch::start(context, standing.file);
  if (!started) return started.error();
  SceneWatch& watch = started.value();
  Series series{context.case_name, {}, {}, {}};
  const std::uint64_t frames = watch.frames_of(kSeconds);
  const std::uint64_t sampled = std::max<std::uint64_t>(1, watch.frames_of(0.25));
  double drift_m = 0;
  double most_kinetic_j = 0;
  for (std::uint64_t i = 1; i <= frames; ++i) {
    watch.step();
    if (i == watch.frames_of(standing.measured_from_s)) watch.remember();
    const bool measured = i >= watch.frames_of(standing.measured_from_s);
    if (measured) drift_m = std::max(drift_m, watch.drift_m());
    if (i >= watch.frames_of(standing.calm_from_s)) most_kinetic_j = std::max(most_kinetic_j, watch.kinetic_j());
    if (i % sampled != 0) continue;
    series.time_s.push_back(static_cast<double>(i) * watch.scene().dt_s);
    series.drift_m.push_back(measured ? watch.drift_m() : 0);
    series.kinetic_j.push_back(watch.kinetic_j());
    const Status go_on = context.at(static_cast<double>(i) / static_cast<double>(frames));
    if (!go_on) return go_on;
  }
  context.series.push_back(std::move(series));
  if (!standing.thrown)
    context.add("bodies that fell by more than a tenth of their size", "", static_cast<double>(watch.fallen()), 0);
  if (standing.thrown) {
    const std::size_t lost = rim_radius_m > 0 ? out_of_bowl(watch, rim_radius_m) : watch.outside();
    context.add(rim_radius_m > 0 ? "bodies out of the bowl" : "bodies out of the tray", "", static_cast<double>(lost),
                0);
  }
  context.add("largest drift", "m", drift_m, standing.drift_m);
  context.add("kinetic energy at the end", "J", watch.kinetic_j(), {});
  context.add("largest kinetic energy once calm", "J", most_kinetic_j, {});
  context.add("largest kinetic energy once calm, a body in m g R", "1", most_kinetic_j / watch.weight_scale_j(), 1e-3);
  context.add("largest speed at the end", "m/s", watch.largest_speed_mps(), 0.2);
  return Done{};
}

}  // namespace

Status stack_of_spheres(Context& context) {
  return stand(context, {.file = "accuracy/stack-5-spheres.json", .drift_m = 1e-6});
}
Status stack_of_boxes(Context& context) {
  return stand(context, {.file = "accuracy/stack-10-boxes.json", .drift_m = {}});
}
Status wall_of_bricks(Context& context) {
  return stand(context, {.file = "accuracy/wall-50-bricks.json", .drift_m = {}});
}
Status arch(Context& context) { return stand(context, {.file = "accuracy/arch-11-wedges.json", .drift_m = {}}); }
Status card_house(Context& context) { return stand(context, {.file = "accuracy/card-house-3.json", .drift_m = {}}); }
Status heavy_on_top(Context& context) { return stand(context, {.file = "accuracy/mass-400.json", .drift_m = {}}); }
Status chain_of_masses(Context& context) { return stand(context, {.file = "accuracy/chain-1000.json", .drift_m = {}}); }
Status mixed_pile(Context& context) {
  return stand(context, {.file = "accuracy/pile-1000-mixed.json",
                         .measured_from_s = 10,
                         .calm_from_s = 10,
                         .drift_m = {},
                         .thrown = true});
}
Status bowl_of_spheres(Context& context) {
  return stand(context,
               {.file = "accuracy/bowl-of-spheres.json",
                .measured_from_s = 10,
                .calm_from_s = 10,
                .drift_m = {},
                .thrown = true},
               1.9);
}

}  // namespace poise::accuracy
