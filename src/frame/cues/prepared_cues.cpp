// SPDX-License-Identifier: MIT
#include "frame/cues/prepared_cues.h"

#include "frame/cues/pair_place.h"
#include "frame/refine/refine.h"

namespace poise::simulation {
namespace {

// Pairs that are counted for crowding, at most. Chosen: bounds the time to 0.1 ms.
constexpr std::size_t kMostCounted = 4096;

void count_crowd(const RefineInput& input, CrowdMap& crowd) {
  crowd.begin(input.step.view);
  const std::size_t stride = input.table.size() / kMostCounted + 1;
  for (std::size_t i = input.frame % stride; i < input.table.size(); i += stride) {
    if (input.table.start[i].refinable())
      crowd.add(place_of(input.motion, input.table.pairs[i]).point_m, static_cast<float>(stride));
  }
}

}  // namespace

void prepare_cues(const RefineInput& input, PreparedCues& prepared, parallel::Executor& executor) {
  const View& view = input.step.view;
  if (view.present && input.policy.occlusion != 0)
    find_hidden(input.scene, input.motion, view, prepared.occlusion, executor);
  prepared.crowd_counted = view.present && input.policy.crowding != 0;
  if (prepared.crowd_counted) count_crowd(input, prepared.crowd);
}

}  // namespace poise::simulation
