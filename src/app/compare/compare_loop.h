// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/compare/comparison.h"

namespace poise::app {

/// What the budgets of a comparison count.
enum class BudgetUnit : std::uint8_t {
  Work,     ///< node-pair expansions
  Percent,  ///< of the work of full refinement of the frame
  Ms,       ///< wall time of the frame
};
/// `work_units`, `percent` or `ms`.
const char* budget_unit_name(BudgetUnit unit);

/// A policy that takes part.
struct Competitor {
  std::string name;
  scheduler::Policy policy;
  bool file = false;    ///< `name` is a policy file that is still to be read
  bool oracle = false;  ///< ranks the pairs of each state by what refining them is worth (verify/refinement_oracle.h)
};

/// How states are made and stepped.
struct CompareSettings {
  std::vector<Competitor> competitors;
  std::vector<double> budgets;
  BudgetUnit unit = BudgetUnit::Percent;
  std::optional<double> from;  ///< budget of the run that makes the states, node-pair expansions or ms; empty: none
  bool from_percent = false;   ///< `from` is a share of the work of full refinement of each frame
  Competitor from_policy;      ///< of the run that makes the states
  std::uint64_t warm_up = 0;   ///< frames before the first state
  std::uint64_t every = 1;     ///< frames from state to state
  std::uint64_t states = 1;
  std::uint64_t history = 1;  ///< frames that each policy steps by itself; the last one is measured
};

/// A time of so many milliseconds.
Nanoseconds of_ms(double ms);

/// Called with each state that is compared, which is that before `frame`. It leaves the run in this state.
using StateVisit = std::function<Status(std::uint64_t frame)>;

/// Runs the scene through all states. `told` gets the share that is done; where it returns false the loop ends.
/// Refused: what the World and `visit` refuse.
Status visit_states(const Scene& scene, SceneRun& run, const CompareSettings& settings, const StateVisit& visit,
                    const std::function<bool(double share)>& told);

/// Runs the scene and steps each state by all policies and budgets. `told` gets the share that is done; where it
/// returns false the loop ends with what is done (whole states only). Refused: what the World refuses.
Result<io::ComparedSteps> compare_loop(const Scene& scene, SceneRun& run, const CompareSettings& settings,
                                       const std::function<bool(double share)>& told);

}  // namespace poise::app
