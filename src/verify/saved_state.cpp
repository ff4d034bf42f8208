// SPDX-License-Identifier: MIT
#include "verify/saved_state.h"

namespace poise::simulation {

void save(const WorldState& world, SavedState& saved) {
  world.settle();
  saved.bodies = world.bodies;
  saved.shape_of = world.shape_of;
  saved.cache = world.cache;
  saved.body_changes = world.body_changes;
  saved.events = world.events;
  saved.sleeping = world.sleeping;
  saved.learned = world.learned;
  saved.frame = world.frame;
  saved.frames_without_step = world.frames_without_step;
}

void restore(const SavedState& saved, WorldState& world) {
  world.settle();
  world.bodies = saved.bodies;
  world.shape_of = saved.shape_of;
  world.cache = saved.cache;
  world.body_changes = saved.body_changes;
  world.events = saved.events;
  world.sleeping = saved.sleeping;
  world.learned = saved.learned;
  world.frame = saved.frame;
  world.frames_without_step = saved.frames_without_step;
  // What stages know of bodies at rest is that of another state.
  world.outputs.motion.everything = true;
  world.outputs.velocities.everything = true;
  world.broad_phase.cache = {};
  world.broad_phase.resting.clear();
  // Queries and lists of contacts are made anew.
  ++world.changes;
  ++world.contacts_version;
}

}  // namespace poise::simulation
