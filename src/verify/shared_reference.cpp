// SPDX-License-Identifier: MIT
#include "verify/shared_reference.h"

#include "verify/world_access.h"

namespace poise::simulation {

void SharedReference::save(World& world) { simulation::save(WorldAccess::of(world), saved_); }
void SharedReference::rewind(World& world) const { restore(saved_, WorldAccess::of(world)); }

void SharedReference::begin(World& world) {
  remember(WorldAccess::of(world), reference_);
  made_ = false;
}

ReferenceFigures SharedReference::compare(World& world, const StepInput& input, std::vector<ComparedBody>* touched) {
  WorldState& state = WorldAccess::of(world);
  state.settle();
  if (!made_) make_reference(state, input, state.pools, reference_);
  made_ = true;
  return compare_with(state, input, reference_, touched);
}

}  // namespace poise::simulation
