// SPDX-License-Identifier: MIT
#include "app/compare/compare_loop.h"

#include <cmath>

#include "app/compare/state_trials.h"

namespace poise::app {
namespace {

using simulation::SharedReference;

// The budget of the frame that leads to the next state.
Result<Budget> budget_from(SceneRun& run, const CompareSettings& settings, const StepInput& input,
                           SharedReference& unlimited) {
  if (!settings.from) return Budget::unlimited();
  if (settings.unit == BudgetUnit::Ms) return Budget::within(of_ms(*settings.from));
  if (!settings.from_percent) return Budget::work(static_cast<std::uint64_t>(*settings.from));
  unlimited.save(run.world());
  const FrameReport report = run.world().step(input);
  unlimited.rewind(run.world());
  if (report.status != StepStatus::Done) return bad_input("the step was refused: its input is out of range");
  return Budget::work(
      static_cast<std::uint64_t>(std::llround(0.01 * *settings.from * static_cast<double>(report.work_refine))));
}

}  // namespace

Nanoseconds of_ms(double ms) { return Nanoseconds(static_cast<std::int64_t>(ms * 1e6)); }

const char* budget_unit_name(BudgetUnit unit) {
  switch (unit) {
    case BudgetUnit::Work:
      return "work_units";
    case BudgetUnit::Percent:
      return "percent";
    case BudgetUnit::Ms:
      return "ms";
  }
  return "work_units";
}

Status visit_states(const Scene& scene, SceneRun& run, const CompareSettings& settings, const StateVisit& visit,
                    const std::function<bool(double share)>& told) {
  SharedReference unlimited;
  const std::uint64_t total = settings.warm_up + (settings.states - 1) * settings.every + 1;
  Status done = run.world().set_policy(settings.from_policy.policy);
  if (!done) return done;
  for (std::uint64_t i = 0; i < total; ++i) {
    done = run.before_frame(i);
    if (!done) return done;
    if (i >= settings.warm_up && (i - settings.warm_up) % settings.every == 0) {
      done = visit(i);
      if (!done) return done;
    }
    if (!told(static_cast<double>(i + 1) / static_cast<double>(total))) break;
    if (i + 1 == total) break;
    StepInput input = compared_input(scene, run.view());
    const Result<Budget> budget = budget_from(run, settings, input, unlimited);
    if (!budget) return budget.error();
    input.budget = budget.value();
    if (run.world().step(input).status != StepStatus::Done)
      return bad_input("the step was refused: its input is out of range");
  }
  return Done{};
}

Result<io::ComparedSteps> compare_loop(const Scene& scene, SceneRun& run, const CompareSettings& settings,
                                       const std::function<bool(double share)>& told) {
  io::ComparedSteps all;
  for (const Competitor& competitor : settings.competitors) all.policies.push_back(competitor.name);
  all.budgets = settings.budgets;
  SharedReference shared;
  const auto compare = [&](std::uint64_t frame) -> Status {
    StateTrials trials(scene, run, settings, shared, frame);
    for (const Competitor& competitor : settings.competitors) {
      for (const double budget : settings.budgets) {
        const Result<io::ComparedStep> step = trials.trial(competitor, budget);
        if (!step) return step.error();
        all.steps.push_back(step.value());
      }
    }
    return trials.end();
  };
  const Status done = visit_states(scene, run, settings, compare, told);
  if (!done) return done.error();
  return all;
}

}  // namespace poise::app
