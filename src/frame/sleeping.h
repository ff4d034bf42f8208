// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "frame/integrate.h"
#include "world/sleeping_state.h"

/// Islands of bodies at rest fall asleep (WorldSettings::sleeping). A body asleep counts as static for all else in the
/// frame, so that its pairs drop out of the broad phase; their cached pairs are put aside and come back when it wakes.
///
/// Invariants: the bodies that fell asleep together wake together, but for those that the caller wakes between two
/// steps: these are ahead of the others until the next step begins. In a frame's pairs no body that sleeps stands
/// beside one that does not and is not static.
///
/// All are called from the thread that steps, or changes, the World, and do nothing in a World without sleeping. The
/// same result on any number of threads.
namespace poise::simulation {

/// What sleeping may change.
struct SleepAccess {
  dynamics::BodyStore& bodies;
  ContactCache& cache;
  SleepingState& sleeping;
};

/// The caller moves a body, pushes it, changes what it meets, adds it or is about to remove it. It wakes, and at the
/// next step the rest of its island; if it is static, what lay near it or lies near it then.
void request_wake(const SleepAccess& access, std::uint32_t slot);

/// Wakes all, as when gravity changes. Between steps.
void wake_all(const SleepAccess& access, parallel::Executor& executor);

/// Before *predict*: wakes what the caller's calls concern.
void wake_near_changes(const SleepAccess& access, parallel::Executor& executor);

/// After *coarse*: wakes the islands of which a body is in a pair with one that moves freely. True if there are any;
/// then the stages from *predict* on must be done anew, and this asked again. False after as many calls as there are
/// islands, and one more.
bool wake_touched(const PairTable& table, const SleepAccess& access, parallel::Executor& executor);

/// After *publish*: counts for how long bodies have been still, puts islands to sleep, and fills the counters of the
/// report.
///
/// A body is still while both |v| and R |w|, and what moved it and its surface in the step over dt_s, are at most 0.01
/// sqrt(g R), with R its bounding radius and g the acceleration of gravity: a hundredth of the speed at which it would
/// fall through half its radius. An island is what the frame's pairs connect, static bodies aside; it sleeps once each
/// of its bodies has been still for half a second, and none is in a pair with a kinematic body that moves.
struct FallAsleepInput {
  const PredictedMotion& motion;
  const PairTable& table;
  const StepMotions& motions;
  double dt_s = 0;
  double gravity_mps2 = 0;
};
void fall_asleep(const FallAsleepInput& input, const SleepAccess& access, FrameReport& report,
                 parallel::Executor& executor);

}  // namespace poise::simulation
