// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"
#include "verify/pair_probe.h"

namespace poise::simulation {

/// The stages of a step over the bodies of a World, with data of its own: the World is only read. For the pair probe,
/// which stops between stages and looks at their outputs. On the calling thread of the World's executor.
class PairStages {
 public:
  explicit PairStages(const WorldState& world);

  /// *predict* to *coarse*, and all pairs at level 0.
  void find(ProbeLevel level, double dt_s);
  /// All pairs to their deepest level, one after another. False if a front had no room. Fronts that are not kept leave
  /// theirs to the next pair.
  bool refine_all(bool keep_fronts);
  /// Every pair has a contact, whatever its separation: for make_rows.
  void meet_all();
  /// *manifolds*, and all rows of *solve*.
  void make_rows();
  /// Every row meets at once, whatever its gap.
  void close_gaps();
  /// The impulses of impacts.
  void solve();

  [[nodiscard]] const Frame& frame() const { return frame_; }
  [[nodiscard]] const WorldState& world() const { return world_; }

 private:
  [[nodiscard]] SolveInput solve_input() const;

  const WorldState& world_;
  StepTerms terms_;
  Frame frame_;
  PointCache points_;
  collision::BroadPhase broad_phase_;
  CandidateCache candidate_cache_;
  std::vector<collision::FrontPool> pools_;
};

}  // namespace poise::simulation
