// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "response/rest.h"
#include "response/rest_lanes.h"

namespace poise::response {

// Lanes and motions in one precision.
template <class T>
struct Lanes {
  std::vector<PatchLanes<T>> patches;
  std::vector<FrictionLanes<T>> friction;
  std::vector<Motion<T>> motions;   // one a body
  std::vector<Motion<T>> begun;     // velocities and spins when the substep began

  std::span<PatchLanes<T>> patches_of(const RestBlock& block) { return std::span(patches).subspan(block.first, block.patches); }
  std::span<FrictionLanes<T>> friction_of(const RestBlock& block) {
    return friction.empty() || !block.rubs ? std::span<FrictionLanes<T>>() : std::span(friction).subspan(block.first, block.patches);
  }
};

/// Makes the lanes of a block from its pairs.
template <class T>
void fill_block(const RestSystem& system, double still_mps, RestBlock& block, Lanes<T>& lanes);

/// Adds what a substep came to, to what the step came to.
template <class T>
void add_totals(const RestBlock& block, Lanes<T>& lanes);

/// Gives the bodies of a block what its patches came to in the step, in double precision and at one point for both bodies of each, and the patches what
/// the next step starts with.
template <class T>
void give_block(const RestSystem& system, const RestBlock& block, Lanes<T>& lanes);

extern template void fill_block(const RestSystem&, double, RestBlock&, Lanes<float>&);
extern template void fill_block(const RestSystem&, double, RestBlock&, Lanes<double>&);
extern template void add_totals(const RestBlock&, Lanes<float>&);
extern template void add_totals(const RestBlock&, Lanes<double>&);
extern template void give_block(const RestSystem&, const RestBlock&, Lanes<float>&);
extern template void give_block(const RestSystem&, const RestBlock&, Lanes<double>&);

}  // namespace poise::response
