// SPDX-License-Identifier: MIT
#include "frame/cues/occlusion.h"

#include <algorithm>

#include "frame/world_state.h"
#include "parallel/ranges.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kHiddenGrain = 256;
// A body that is smaller than a cell and a half, as a share of the image's height, fills no cell. Its root sphere is
// larger than it.
constexpr float kLeastSize = 1.5F / DepthBuffer::kHeight;

// Of a body's root sphere; 0 of what is behind the eye or outside the image.
float size_of(const ViewQuery& view_query, const BodyBounds& body) {
  if (body.plane || !in_frustum(view_query, body.root_center_m, body.root_radius_m)) return 0;
  const double depth_m = (body.root_center_m - view_query.view.position_m).dot(view_query.view.forward);
  if (!(depth_m > body.root_radius_m)) return depth_m > 0 ? 1.0F : 0.0F;
  return static_cast<float>(std::min(1.0, body.root_radius_m / (depth_m * view_query.tangent_up)));
}

// The largest, in an order that depends on nothing else.
void choose_occluders(const SceneView& scene, const PredictedMotion& motion, const ViewQuery& view_query,
                      Occlusion& occlusion, parallel::Executor& executor) {
  const auto size = [&](std::size_t slot) {
    return scene.bodies.alive[slot] == 0 || scene.facts_of(slot).inner_solids.empty()
               ? 0.0F
               : size_of(view_query, motion.body_bounds[slot]);
  };
  auto& occluders = occlusion.occluders;
  occluders.reserve(scene.bodies.slot_count());
  parallel::select(
      executor, scene.bodies.slot_count(), kHiddenGrain, occlusion.counts,
      [&](std::size_t slot) { return size(slot) >= kLeastSize; }, [&](std::size_t count) { occluders.resize(count); },
      [&](std::size_t slot, std::size_t position) {
        occluders[position] = {size(slot), static_cast<std::uint32_t>(slot)};
      });
  const std::size_t most = std::min(occluders.size(), Occlusion::kMostOccluders);
  std::partial_sort(occluders.begin(), occluders.begin() + static_cast<std::ptrdiff_t>(most), occluders.end(),
                    [](const Occlusion::Occluder& x, const Occlusion::Occluder& y) {
                      return x.size != y.size ? x.size > y.size : x.slot < y.slot;
                    });
  occluders.resize(most);
}

}  // namespace

void find_inner_solids(WorldState& world) {
  if (world.settings.policy.occlusion == 0) return;
  for (ShapeFacts& facts : world.shapes) {
    if (facts.inner_solids_found || !facts.shape) continue;
    facts.inner_solids = query::inner_solids(facts.shape);
    facts.inner_solids_found = true;
  }
}

void find_hidden(const SceneView& scene, const PredictedMotion& motion, const ViewQuery& view_query,
                 Occlusion& occlusion, parallel::Executor& executor) {
  choose_occluders(scene, motion, view_query, occlusion, executor);
  occlusion.depth.begin(view_query);
  for (const Occlusion::Occluder& occluder : occlusion.occluders) {
    const collision::Pose& pose = motion.poses[occluder.slot];
    for (const query::InnerSolid& solid : scene.facts_of(occluder.slot).inner_solids)
      occlusion.depth.add(solid, pose.position_m, pose.rotation);
  }
  const std::size_t slots = scene.bodies.slot_count();
  occlusion.hidden.resize(slots);
  parallel::parallel_for(executor, slots, kHiddenGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t slot = begin; slot < end; ++slot) {
      const BodyBounds& body = motion.body_bounds[slot];
      occlusion.hidden[slot] = scene.bodies.dynamic[slot] != 0 && !body.plane &&
                                       occlusion.depth.hides(body.root_center_m, body.root_radius_m)
                                   ? 1
                                   : 0;
    }
  });
  occlusion.found = true;
}

}  // namespace poise::simulation
