// SPDX-License-Identifier: MIT
#include "frame/refine/pair_cues.h"

#include "frame/host_cues.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// What the viewer sees of a pair that is known by its root spheres alone: it touches where the smaller one is nearest
// to the other.
PairView pair_view_of(const RefineInput& input, const ActivePair& pair) {
  const BodyBounds& a = input.motion.body_bounds[pair.a];
  const BodyBounds& b = input.motion.body_bounds[pair.b];
  PairView pair_view;
  if (b.plane) {
    pair_view.normal = -b.position_m;
    pair_view.point_m = a.root_center_m + a.root_radius_m * pair_view.normal;
  } else {
    const Vec3 between = b.root_center_m - a.root_center_m;
    const double distance = between.norm();
    if (distance > 0) pair_view.normal = between / distance;
    pair_view.point_m = a.root_radius_m <= b.root_radius_m
                            ? Vec3(a.root_center_m + std::min(a.root_radius_m, distance) * pair_view.normal)
                            : Vec3(b.root_center_m - std::min(b.root_radius_m, distance) * pair_view.normal);
  }
  pair_view.extent_m = pair.skin_m / kSkin;
  pair_view.closing_mps = pair_view.normal.dot(a.velocity_mps - b.velocity_mps);
  pair_view.importance = input.scene.bodies.importance[pair.a] * input.scene.bodies.importance[pair.b];
  pair_view.frames_waited = pair.cached.frames_waited;
  return pair_view;
}

}  // namespace

bool PairCueSource::fill(std::uint32_t index, scheduler::PairCues& cues) const {
  const ActivePair& pair = input_.table.pairs[index];
  const PairView view = pair_view_of(input_, pair);
  cues = cues_of(view_query_, view, input_.policy);
  if (input_.policy.cue.function == nullptr) return true;
  const scheduler::HostFactor host = scheduler::host_factor(
      input_.policy.cue, host_view_of(view_query_, view, pair.id(), user_data_of(input_.scene, pair)));
  cues.host = host.factor;
  return !host.refused;
}

double PairCueSource::seen(std::uint32_t index) const {
  PairView view = pair_view_of(input_, input_.table.pairs[index]);
  view.frames_waited = 0;
  const scheduler::PairCues cues = cues_of(view_query_, view, input_.policy);
  return scheduler::cue_weight(input_.policy, cues) * cues.angle_radpm;
}

std::size_t fill_all_cues(const RefineInput& input, CompletedLevels& levels, parallel::Executor& executor) {
  constexpr std::size_t kGrain = 128;
  const PairCueSource source(input);
  parallel::Tickets refused;
  parallel::parallel_for(executor, levels.progress.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    std::size_t of_range = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (levels.progress[i].refinable() && !source.fill(static_cast<std::uint32_t>(i), levels.cues[i])) ++of_range;
    }
    if (of_range > 0) refused.take(of_range);
  });
  return refused.take(0);
}

}  // namespace poise::simulation
