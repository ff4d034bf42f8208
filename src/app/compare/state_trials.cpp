// SPDX-License-Identifier: MIT
#include "app/compare/state_trials.h"

#include <array>
#include <cmath>

#include "verify/world_access.h"

namespace poise::app {
namespace {

// Of the work of full refinement: where the oracle looks again at what is left to gain. Chosen: errors fall by about as
// much from one to the next.
constexpr std::array kOracleShares{0.02, 0.05, 0.1, 0.2, 0.35, 0.6, 1.0};

}  // namespace

StepInput compared_input(const Scene& scene, const View& view) {
  StepInput input;
  input.dt_s = scene.dt_s;
  input.max_level = scene.max_level;
  input.polygons = scene.polygons;
  input.backtracking = scene.backtracking;
  input.view = view;
  return input;
}

StateTrials::StateTrials(const Scene& scene, SceneRun& run, const CompareSettings& settings,
                         simulation::SharedReference& shared, std::uint64_t frame)
    : scene_(scene), world_(run.world()), settings_(settings), shared_(shared), view_(run.view()), frame_(frame) {
  shared_.save(world_);
}

StepInput StateTrials::input_at(std::uint64_t frame) const {
  return compared_input(scene_, frame == frame_ ? view_ : scene_view(scene_, static_cast<double>(frame) * scene_.dt_s));
}

Status StateTrials::step(const StepInput& input, FrameReport& report) {
  report = world_.step(input);
  if (report.status == StepStatus::Done) return Done{};
  return bad_input("the step was refused: its input is out of range");
}

// What budgets need to know of the state, and where its reference begins.
Status StateTrials::prepare() {
  if (settings_.unit == BudgetUnit::Percent) {
    FrameReport report;
    const Status done = step(input_at(frame_), report);
    if (!done) return done;
    full_units_ = static_cast<double>(report.work_refine);
    shared_.rewind(world_);
  }
  shared_.begin(world_);
  prepared_ = true;
  return Done{};
}

Status StateTrials::prepare_oracle() {
  StepInput full = input_at(frame_);
  full.record = true;
  FrameReport report;
  const Status done = step(full, report);
  if (!done) return done;
  full_units_ = static_cast<double>(report.work_refine);
  world_.decisions(decisions_);
  shared_.rewind(world_);
  return ask_oracle();
}

Status StateTrials::ask_oracle() {
  StepInput again = input_at(frame_);
  again.replay = &decisions_;
  FrameExplanation explained;
  again.explain = &explained;
  FrameReport report;
  Status done = step(again, report);
  if (!done) return done;
  std::vector<std::uint64_t> units(explained.pairs.size(), 0);
  for (const LevelExplanation& level : explained.levels) units[level.pair] += level.units;
  // Gains are those of the others' current levels, so they are taken anew as the order grows.
  simulation::OracleOrder order;
  StepInput next = input_at(frame_);
  for (const double share : kOracleShares) {
    shared_.rewind(world_);
    oracle_.emplace(order.ids);
    done = world_.set_policy(oracle_policy(scene_.policy));
    next.budget = Budget::work(order.units);
    if (done) done = step(next, report);
    if (!done) return done;
    shared_.compare(world_, next);
    const auto until = static_cast<std::uint64_t>(share * full_units_) + 1;
    simulation::extend(simulation::WorldAccess::of(world_), shared_.reference(), next.view, units, until, order);
  }
  oracle_.emplace(order.ids);
  return done;
}

scheduler::Policy StateTrials::oracle_policy(scheduler::Policy policy) const {
  policy.kind = scheduler::PolicyKind::Custom;
  policy.custom = oracle_->policy();
  return policy;
}

Budget StateTrials::budget_of(double budget) const {
  switch (settings_.unit) {
    case BudgetUnit::Work:
      return Budget::work(static_cast<std::uint64_t>(budget));
    case BudgetUnit::Percent:
      return Budget::work(static_cast<std::uint64_t>(std::llround(0.01 * budget * full_units_)));
    case BudgetUnit::Ms:
      return Budget::within(of_ms(budget));
  }
  return Budget::unlimited();
}

Result<io::ComparedStep> StateTrials::trial(const Competitor& competitor, double budget) {
  shared_.rewind(world_);
  Status done = prepared_ ? Status(Done{}) : prepare();
  if (done && competitor.oracle && !oracle_) {
    done = prepare_oracle();
    shared_.rewind(world_);
  }
  if (!done) return done.error();
  done = world_.set_policy(competitor.oracle ? oracle_policy(competitor.policy) : competitor.policy);
  FrameReport report;
  StepInput input;
  for (std::uint64_t k = 0; done && k < settings_.history; ++k) {
    if (settings_.history > 1 && k + 1 == settings_.history) shared_.begin(world_);
    input = input_at(frame_ + k);
    input.budget = budget_of(budget);
    done = step(input, report);
  }
  if (!done) return done.error();
  const ReferenceFigures figures = shared_.compare(world_, input);
  io::ComparedStep measured;
  measured.converged = figures.converged;
  measured.e_mps = figures.e_mps;
  measured.e_rel = figures.e_rel;
  measured.e_seen_mps = figures.e_seen_mps;
  measured.gap_mean_px = figures.gap_mean_px;
  measured.false_rate = figures.false_rate;
  measured.work_units = static_cast<double>(report.work_refine);
  measured.time_ms = static_cast<double>(report.times.total.count()) / 1e6;
  return measured;
}

Status StateTrials::end() {
  shared_.rewind(world_);
  return world_.set_policy(settings_.from_policy.policy);
}

}  // namespace poise::app
