// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "poise/world.h"
#include "verify/reference.h"
#include "verify/saved_state.h"

namespace poise::simulation {

/// Steps a World several times from one state, each time in another way, and compares the steps with one reference. Not
/// for Worlds with sleeping. Invariant: buffers only grow.
class SharedReference {
 public:
  /// Saves the state that `rewind` leads back to.
  void save(World& world);
  void rewind(World& world) const;

  /// The next steps that are compared begin at the current state, of which the next comparison makes a reference.
  void begin(World& world);
  /// Compares the step with `input` that has just been done from the state of `begin`. All steps from that state must
  /// have the same input but for their budget and the World's policy, and for their view if `input` is given here
  /// without one: weights and pixels are then not those of a viewer. `touched` as of compare_with.
  ReferenceFigures compare(World& world, const StepInput& input, std::vector<ComparedBody>* touched = nullptr);

  /// Of the last comparison.
  [[nodiscard]] const Reference& reference() const { return reference_; }

 private:
  SavedState saved_;
  Reference reference_;
  bool made_ = false;
};

}  // namespace poise::simulation
