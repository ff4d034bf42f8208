// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "poise/decisions.h"
#include "poise/step.h"

namespace poise::simulation {

/// The steps of refinement of one frame, as the workers note them. Invariant: each worker's steps stand in the order of
/// time.
///
/// Each worker writes to its own list and to no other; the lists are reserved for everything that a frame can do, so
/// that noting allocates nothing once a frame of that size has begun.
class DecisionLog {
 public:
  /// Forgets the last frame. `most_steps` is how many one worker may come to note.
  void begin(std::uint64_t frame, std::size_t active_pairs, std::size_t workers, std::size_t most_steps);
  /// The frame is not recorded: nothing is known of it.
  void forget() { known_ = false; }
  /// The step goes on in the next frame: nothing else is known of this one.
  void unfinished(std::uint64_t frame) {
    unfinished_ = true;
    frame_ = frame;
  }
  /// It has ended, in this frame.
  void finished(std::uint64_t frame) {
    unfinished_ = false;
    frame_ = frame;
  }

  /// From the thread of `worker`.
  void note(int worker, std::uint32_t pair, RefinementStep::Kind kind, SteadyClock::time_point when) {
    lanes_[static_cast<std::size_t>(worker)].steps.push_back({when, pair, kind});
  }
  /// For work that goes in rounds: from the thread that chooses them, in their order.
  void note_round(std::uint32_t pair, RefinementStep::Kind kind) { note(0, pair, kind, SteadyClock::time_point{}); }

  /// FrameDecisions::learns is true. From the thread of the step, after begin.
  void learns() { learns_ = true; }
  /// What the frame left out because it could not be done in time: the substeps that it had (0: all), and a pair that
  /// reused what is cached of it though that was too old. From the thread of the step, after begin.
  void substeps(std::uint32_t count) { substeps_ = count; }
  /// Likewise the point iterations that a substep may make (0: as many as the solver does by itself).
  void point_iterations(std::uint32_t most) { point_iterations_ = most; }
  /// FrameDecisions::stopped_after.
  void stopped_after(std::span<const std::uint32_t> iterations) {
    stopped_after_.clear();
    if (std::any_of(iterations.begin(), iterations.end(), [](std::uint32_t made) { return made > 0; }))
      stopped_after_.assign(iterations.begin(), iterations.end());
  }
  /// FrameDecisions::crowded_partners.
  void crowded_partners(std::uint32_t count) { crowded_partners_ = count; }
  void reused(std::uint32_t pair) { reused_.push_back(pair); }
  /// That all paused islands took part again, and those that wait for several steps from now on.
  void resumed() { resumed_ = true; }
  void paused(std::span<const PausedIsland> islands) { paused_.assign(islands.begin(), islands.end()); }
  /// And the islands that waited, by their roots, ascending.
  void held(std::span<const std::uint32_t> roots) { held_.assign(roots.begin(), roots.end()); }

  /// All lists as one, by time; of one time the lower worker first. Uses the memory of `decisions` again.
  void merge(FrameDecisions& decisions) const;

 private:
  struct Step {
    SteadyClock::time_point when;
    std::uint32_t pair;
    RefinementStep::Kind kind;
  };
  // One cache line each: what one worker notes must not hold up the others.
  struct alignas(64) Lane {
    std::vector<Step> steps;
  };
  std::vector<Lane> lanes_;
  std::uint64_t frame_ = 0;
  std::size_t active_pairs_ = 0;
  std::uint32_t substeps_ = 0, point_iterations_ = 0, crowded_partners_ = 0;
  std::vector<std::uint32_t> reused_, held_, stopped_after_;
  std::vector<PausedIsland> paused_;
  bool resumed_ = false;
  bool learns_ = false;
  bool known_ = false;
  bool unfinished_ = false;
};

}  // namespace poise::simulation
