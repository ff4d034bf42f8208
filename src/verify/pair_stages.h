// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"
#include "verify/pair_probe.h"

namespace poise::simulation {

/// The stages of a step on the bodies of a World, with separate data: the World is only read. For the pair probe, which
/// stops between stages and reads their outputs. Runs on the calling thread with the World's executor.
class PairStages {
 public:
  explicit PairStages(const WorldState& world);

  /// Runs *predict* to *coarse*, and refines all pairs to level 0.
  void find(ProbeLevel level, double dt_s);
  /// Refines all pairs to their deepest level, one after another. Returns false if the capacity of a front was too
  /// small. Without `keep_fronts` the next pair reuses the capacity.
  bool refine_all(bool keep_fronts);
  /// Gives every pair a contact, whatever its separation: for make_rows.
  void meet_all();
  /// Runs *manifolds*, and makes all rows of *solve*.
  void make_rows();
  /// Makes every row act immediately, whatever its separation.
  void close_gaps();
  /// Computes the impulses of impacts.
  void solve();

  [[nodiscard]] const Frame& frame() const { return frame_; }
  [[nodiscard]] const WorldState& world() const { return world_; }

 private:
  [[nodiscard]] SolveInput solve_input() const;

  const WorldState& world_;
  StepTerms terms_;
  Frame frame_;
  PointCache points_;
  BroadPhaseState broad_phase_;
  std::vector<collision::FrontPool> pools_;
};

}  // namespace poise::simulation
