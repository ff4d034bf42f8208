// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "app/compare/compare_loop.h"
#include "verify/refinement_oracle.h"
#include "verify/shared_reference.h"

namespace poise::app {

/// Steps of one state by several policies and budgets, each from the same bits, measured by one reference. Invariant:
/// `shared` holds the state of `frame`. Work of full refinement, oracle and reference are computed once, when first
/// needed.
class StateTrials {
 public:
  /// Saves the state of the run before `frame`. All arguments must outlive the trials, and no other trials may use
  /// `shared` meanwhile; the run may be stepped on between trials.
  StateTrials(const Scene& scene, SceneRun& run, const CompareSettings& settings, simulation::SharedReference& shared,
              std::uint64_t frame);

  /// Steps and measures. Refused: what the World refuses.
  Result<io::ComparedStep> trial(const Competitor& competitor, double budget);
  /// Puts the run back to the state, with the policy that makes states.
  Status end();

 private:
  [[nodiscard]] StepInput input_at(std::uint64_t frame) const;
  Status step(const StepInput& input, FrameReport& report);
  Status prepare();
  Status prepare_oracle();
  Status ask_oracle();
  [[nodiscard]] scheduler::Policy oracle_policy(scheduler::Policy policy) const;
  [[nodiscard]] Budget budget_of(double budget) const;

  const Scene& scene_;
  World& world_;
  const CompareSettings& settings_;
  simulation::SharedReference& shared_;
  View view_;
  std::uint64_t frame_ = 0;
  bool prepared_ = false;
  double full_units_ = 0;
  FrameDecisions decisions_;
  std::optional<simulation::OracleScores> oracle_;
};

/// The input of the step of `frame` as the scene has it, without a budget.
StepInput compared_input(const Scene& scene, const View& view);

}  // namespace poise::app
