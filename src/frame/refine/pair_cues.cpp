// SPDX-License-Identifier: MIT
#include "frame/refine/pair_cues.h"

#include "frame/cues/answered_gap.h"
#include "frame/cues/attended.h"
#include "frame/cues/known_separation.h"
#include "frame/cues/pair_place.h"
#include "frame/cues/prepared_cues.h"
#include "frame/cues/surface_speed.h"
#include "frame/host_cues.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// Is a cue asked for? What a host's function reads counts as asked for.
bool measures(const scheduler::Policy& policy, double scheduler::Policy::*weight) { return policy.*weight != 0; }
bool measures_closing(const scheduler::Policy& policy) {
  return measures(policy, &scheduler::Policy::closing) || measures(policy, &scheduler::Policy::delay) ||
         policy.cue.function != nullptr || policy.kind == scheduler::PolicyKind::Custom;
}

// Is all that moves of a pair hidden?
bool is_hidden(const RefineInput& input, const ActivePair& pair) {
  const Occlusion& occlusion = input.prepared->occlusion;
  const auto dynamic = [&](std::uint32_t slot) { return input.motion.body_bounds[slot].dynamic; };
  const auto seen = [&](std::uint32_t slot) { return dynamic(slot) && occlusion.hidden[slot] == 0; };
  return (dynamic(pair.a) || dynamic(pair.b)) && !seen(pair.a) && !seen(pair.b);
}

// What the viewer sees of a pair, as far as the policy asks for it.
PairView pair_view_of(const RefineInput& input, const ActivePair& pair) {
  using scheduler::Policy;
  const Policy& policy = input.policy;
  const PairPlace place =
      input.points != nullptr ? place_of(input.motion, pair, *input.points) : place_of(input.motion, pair);
  PairView view;
  view.point_m = place.point_m;
  view.normal = place.normal;
  view.extent_m = pair.skin_m / kSkin;
  if (measures_closing(policy)) view.closing_mps = surface_closing_mps(input.motion, pair, place);
  view.importance = input.scene.bodies.importance[pair.a] * input.scene.bodies.importance[pair.b];
  view.frames_waited = pair.cached->frames_waited;
  if (measures(policy, &Policy::gap)) view.gap_m = answered_gap_m(input.motion, pair);
  if (measures(policy, &Policy::delay) && view.closing_mps > 0)
    view.delay_s = input.terms.dt_s * static_cast<double>(view.frames_waited);
  if (measures(policy, &Policy::onset)) view.age_s = input.terms.dt_s * static_cast<double>(frames_touched(pair));
  if (measures(policy, &Policy::touch)) view.separation = known_separation(input.scene, input.motion, pair);
  if (measures(policy, &Policy::attention))
    view.attended = is_attended(input.step.attention, input.scene.bodies, pair, place.point_m);
  if (input.prepared == nullptr) return view;
  if (input.prepared->occlusion.found) view.hidden = is_hidden(input, pair);
  if (input.prepared->crowd_counted) view.crowd = input.prepared->crowd.others_at(place.point_m);
  return view;
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
  view.delay_s = 0;
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
