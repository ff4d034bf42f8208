// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "frame/world_state.h"
#include "poise/reference.h"
#include "verify/contact_noise.h"
#include "verify/reference_figures.h"

/// The reference of a frame (docs/method.md), used by World::step. It calls remember before a frame and refer after it,
/// both outside the frame's time, and neither in a step without StepInput::reference.
namespace poise::simulation {

/// Copies the state at the start of the frame.
void remember(const WorldState& world, Reference& reference);

/// The contacts whose response is computed. Those of the reference itself are the default.
struct ReferenceContacts {
  Level max_level = kMaxTreeDepth;
  bool polygons = true;
  ContactNoise noise;
};

/// Computes the frame that has just ended again from the remembered state, with separate data and the predicted motion
/// of the run. Uses the World's threads and `pools`, one a worker, which it clears. The result does not depend on the
/// threads.
void make_reference(const WorldState& world, const StepInput& input, std::span<collision::FrontPool> pools,
                    Reference& reference, const ReferenceContacts& contacts = {});

/// Compares a frame that has just ended with the reference, which was made after this frame or after another one from
/// the same state. What depends on that state alone is computed once and kept in the reference. `touched`, if given,
/// receives the bodies over which errors are taken, slots ascending.
ReferenceFigures compare_with(const WorldState& world, const StepInput& input, Reference& reference,
                              std::vector<ComparedBody>* touched = nullptr);

/// Compares the converged response to other contacts with the reference, both made after this frame. Without a view and
/// without gaps. Not for Worlds in which bodies wait.
ReferenceFigures compare_references(const WorldState& world, const Reference& other, const Reference& reference);

/// Of each active pair of a run, which of the reference it is. Both are sorted; the reference also has those that are
/// apart, and those of paused bodies.
std::vector<std::uint32_t> pairs_of_run(const PairTable& run, const PairTable& full);

/// make_reference and compare_with.
ReferenceFigures refer(const WorldState& world, const StepInput& input, std::span<collision::FrontPool> pools,
                       Reference& reference);

}  // namespace poise::simulation
