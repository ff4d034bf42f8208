// SPDX-License-Identifier: MIT
#include "frame/report/levels_reached.h"

#include <algorithm>

#include "frame/run_frame.h"
#include "frame/view_cues.h"

namespace poise::simulation {
namespace {

double radius_m(const WorldState& world, BodyId body) {
  const ShapePtr& shape = world.bodies.shape[body.slot];
  return shape->kind == ShapeKind::Plane ? 1e30 : static_cast<double>(shape->tree.radius_m[0]);
}

// What a viewer can notice of an error at a contact: the cues of the policy but for how long the pair has waited.
double weight_of(const WorldState& world, const ViewQuery& view, const Contact& contact) {
  PairView pair_view;
  pair_view.point_m = contact.point_m;
  pair_view.normal = contact.normal;
  pair_view.extent_m = std::min(radius_m(world, contact.a), radius_m(world, contact.b));
  pair_view.importance = world.bodies.importance[contact.a.slot] * world.bodies.importance[contact.b.slot];
  const scheduler::PairCues cues = cues_of(view, pair_view);
  scheduler::Policy plain;
  plain.waiting = 0;
  return scheduler::cue_weight(plain, cues) * cues.angle_radpm;
}

// Polygons are counted in a bin of their own, whatever level the trees of the pair end at.
std::size_t bin_of(const WorldState& world, const Contact& contact) {
  const auto depth = [&](BodyId body) {
    const ShapePtr& shape = world.bodies.shape[body.slot];
    return shape->kind == ShapeKind::Plane ? Level{0} : shape->tree.depth();
  };
  return contact.level > std::max(depth(contact.a), depth(contact.b)) ? kPolygonBin : contact.level;
}

}  // namespace

LevelsReached levels_reached(const WorldState& world, const View& view) {
  constexpr std::uint8_t kUntouched = 0xffU;
  LevelsReached reached;
  std::vector<std::uint8_t> least(world.bodies.slot_count(), kUntouched);
  const ViewQuery view_query(view);
  const auto count = [&](const Contact& contact) {
    const std::size_t place = bin_of(world, contact);
    reached.weight[place] += weight_of(world, view_query, contact);
    for (const BodyId body : {contact.a, contact.b}) {
      if (world.bodies.dynamic[body.slot] != 0)
        least[body.slot] = std::min(least[body.slot], static_cast<std::uint8_t>(place));
    }
  };
  const PublishInput published = publish_input(world);
  if (published.velocities.swept.hits.empty()) {
    for (std::size_t m = 0; m < published.manifolds.manifolds.size(); ++m)
      count(contact_outline(published, world.cache.points, m));
  } else {
    // What met within the step is one contact with what touched before.
    for (const Contact& contact : list_contacts(published, world.cache.points, {}, ContactListing::Solved))
      count(contact);
  }
  for (const std::uint8_t place : least) {
    if (place != kUntouched) ++reached.bodies[place];
  }
  const Frame& frame = world.outputs;
  for (std::size_t i = 0; i < frame.table.size(); ++i) {
    const PairProgress& pair = frame.levels.progress[i];
    if (pair.apart() || !pair.refinable()) continue;
    ++(pair.full ? reached.left_for_capacity : reached.left_for_time);
    const std::uint32_t waited = frame.table.pairs[i].cached->frames_waited;
    reached.longest_wait = std::max(reached.longest_wait, pair.solved_level() > 0 ? 0U : waited + 1);
  }
  return reached;
}

}  // namespace poise::simulation
