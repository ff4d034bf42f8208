// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "frame/pair_progress.h"
#include "frame/recorded_run.h"
#include "frame/scenes.h"
#include "verify/world_access.h"
#include "world/decision_log.h"

namespace poise {
namespace {

// The budget varies: on any machine some frames refine nothing and some refine everything; the others refine what time
// permits.
Budget budget_of(int frame) {
  if (frame % 10 == 9) return Budget::within(std::chrono::hours(1));
  if (frame % 6 == 0) return Budget::until(SteadyClock::time_point{});
  return Budget::within(std::chrono::microseconds(150 + 100 * (frame % 7)));
}

std::vector<PairOutcome> outcomes_of(World& world) {
  std::vector<PairOutcome> outcomes;
  for (const simulation::PairProgress& pair : simulation::WorldAccess::of(world).outputs.levels.progress)
    outcomes.push_back(simulation::outcome_of(pair));
  return outcomes;
}

Recorded record(const Case& c, int threads) {
  Stage stage(settings_of(c, ExecutorKind::Threads, threads), 0.2);
  fill(c, stage);
  StepInput input = input_of(c);
  input.record = true;
  Recorded recorded;
  for (int i = 0; i < c.frames; ++i) {
    input.budget = budget_of(i);
    // Every other time the pairs go in the order of memory, also where that does not end in time.
    simulation::WorldAccess::of(stage.world).forecasts.pair_cost.in_order_ns = i % 2 == 0 ? 1e-9 : 1e18;
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(report.status, StepStatus::Done);
    recorded.decisions.emplace_back();
    stage.world.decisions(recorded.decisions.back());
    recorded.hashes.push_back(stage.world.state_hash());
    recorded.outcomes.push_back(outcomes_of(stage.world));
    recorded.completed += report.jobs_done;
    recorded.left += report.pairs_left;
    recorded.asleep += report.fell_asleep;
    recorded.swept += report.swept_hits;
    recorded.by_polygons += report.level_histogram[kPolygonBin];
  }
  return recorded;
}

std::vector<Case> cases() {
  using scheduler::PolicyKind;
  std::vector<Case> all(7);
  all[0] = {.name = "fitted"};
  all[1] = {.name = "paper", .contact = ContactModel::Paper};
  all[2] = {.name = "wrench, first come", .contact = ContactModel::Wrench, .policy = PolicyKind::Fifo};
  all[3] = {.name = "random", .policy = PolicyKind::Random};
  all[4] = {.name = "polygons", .polygons = true, .frames = 30};
  all[5] = {.name = "backtracking", .backtracking = true};
  all[6] = {.name = "sleeping", .sleeping = true, .frames = 100};
  return all;
}

TEST(Decisions, AStepOnTheWallClockIsDoneAgainToTheBitOnAnyThreadsAndExecutor) {
  for (const Case& c : cases()) {
    const Recorded recorded = record(c, c.contact == ContactModel::Paper ? 2 : 4);
    // Those of the frames with an hour alone, where the machine has time for no others.
    EXPECT_GT(recorded.completed, 40U) << c.name;
    EXPECT_GT(recorded.left, 0U) << c.name << ": nothing was left coarse, so the clock decided nothing";
    EXPECT_EQ(recorded.by_polygons > 0, c.polygons) << c.name;
    EXPECT_EQ(recorded.swept > 0, c.backtracking) << c.name;
    EXPECT_EQ(recorded.asleep > 0, c.sleeping) << c.name;
    EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Serial, 1), recorded.hashes.size()) << c.name;
    EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Threads, 3), recorded.hashes.size()) << c.name;
    EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Tbb, 2), recorded.hashes.size()) << c.name;
  }
}

TEST(Decisions, WhatInfeasibleFramesLeftOutIsLeftOutAgain) {
  const Case c{.name = "infeasible"};
  WorldSettings settings = settings_of(c, ExecutorKind::Threads, 3);
  settings.islands_wait = IslandsWait::Never;  // else all wait, and nothing is left to leave out
  Stage stage(settings, 0.2);
  fill(c, stage);
  StepInput input = input_of(c);
  input.record = true;
  Recorded recorded;
  std::size_t fewer = 0;
  std::size_t reused = 0;
  for (int i = 0; i < 90; ++i) {
    input.budget = i < 50 ? Budget::within(std::chrono::hours(1)) : Budget::until(SteadyClock::time_point{});
    // A reference after the frame does not affect the decisions.
    input.reference = i % 7 == 0;
    const FrameReport report = stage.world.step(input);
    recorded.decisions.emplace_back();
    stage.world.decisions(recorded.decisions.back());
    recorded.hashes.push_back(stage.world.state_hash());
    EXPECT_EQ(recorded.decisions.back().substeps, static_cast<std::uint32_t>(report.degraded.substeps));
    EXPECT_EQ(recorded.decisions.back().reused.size(), report.degraded.pairs_reused);
    EXPECT_EQ(recorded.decisions.back().point_iterations > 0, i >= 50);
    fewer += report.degraded.substeps > 0 ? 1U : 0U;
    reused += report.degraded.pairs_reused;
  }
  EXPECT_EQ(fewer, 40U);
  EXPECT_GT(reused, 0U);
  EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Serial, 1), recorded.hashes.size());
  EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Threads, 2), recorded.hashes.size());
  Recorded swept = recorded;
  swept.decisions[60].point_iterations = 0;
  EXPECT_EQ(frames_alike(c, swept, ExecutorKind::Serial, 1), 60U)
      << "how often places are visited is part of what is decided";
  Recorded whole = recorded;
  const auto first = std::find_if(whole.decisions.begin(), whole.decisions.end(),
                                  [](const FrameDecisions& d) { return !d.reused.empty(); });
  first->reused.clear();
  EXPECT_EQ(frames_alike(c, whole, ExecutorKind::Serial, 1), static_cast<std::size_t>(first - whole.decisions.begin()))
      << "what is reused is part of what is decided";
}

// Balls in one place, and a few that lie side by side.
void fill_crowd(Stage& stage, int count) {
  const ShapeId ball = stage.ball(0.3);
  for (int i = 0; i < count; ++i)
    stage.add(ball, Vec3(1e-3 * (i % 10), 1e-3 * (i / 10 % 10), 2 + 1e-3 * (i / 100)), Vec3::Zero());
  for (int i = 0; i < 20; ++i) stage.add(ball, Vec3(3 + 0.5 * (i % 5), 0.5 * (i / 5), 2), Vec3::Zero());
}

TEST(Decisions, WhereThereIsNoTimeForAllPairsOfACrowdTheNearestAreSolvedAndTheSameAgain) {
  constexpr int kCrowd = 300;
  const Case c{.name = "crowd"};
  WorldSettings settings = settings_of(c, ExecutorKind::Threads, 3);
  settings.islands_wait = IslandsWait::Never;
  Stage stage(settings, 0.2);
  fill_crowd(stage, kCrowd);
  StepInput input = input_of(c);
  input.record = true;
  Recorded recorded;
  for (int i = 0; i < 6; ++i) {
    const bool hopeless = i % 2 == 1;
    input.budget = hopeless ? Budget::until(SteadyClock::time_point{}) : Budget::within(std::chrono::hours(1));
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(report.degraded.crowded_partners, hopeless ? 1U : 0U);
    if (hopeless) {
      EXPECT_TRUE(report.degraded.any());
      EXPECT_GT(report.pairs_discarded, 0U);
      EXPECT_LE(report.candidate_pairs, 8U * kCrowd + 32 * 32 + 200) << "eight each, and what is no crowd";
    } else {
      EXPECT_GT(report.candidate_pairs, std::size_t{40} * kCrowd) << "all of them";
    }
    recorded.decisions.emplace_back();
    stage.world.decisions(recorded.decisions.back());
    recorded.hashes.push_back(stage.world.state_hash());
  }
  const auto alike = [&](ExecutorKind executor, int threads) {
    Stage again(settings_of(c, executor, threads), 0.2);
    fill_crowd(again, kCrowd);
    StepInput replay = input_of(c);
    for (std::size_t i = 0; i < recorded.hashes.size(); ++i) {
      replay.replay = &recorded.decisions[i];
      again.world.step(replay);
      if (again.world.state_hash() != recorded.hashes[i]) return i;
    }
    return recorded.hashes.size();
  };
  EXPECT_EQ(alike(ExecutorKind::Serial, 1), recorded.hashes.size());
  EXPECT_EQ(alike(ExecutorKind::Tbb, 2), recorded.hashes.size());
  recorded.decisions[3].crowded_partners = 0;
  EXPECT_EQ(alike(ExecutorKind::Serial, 1), 3U) << "it is part of what is decided";
}

TEST(Decisions, TheOrderAndTheWorkersOfLevelsChangeNoBit) {
  const Case c{.name = "fitted"};
  Recorded recorded = record(c, 2);
  for (FrameDecisions& frame : recorded.decisions) {
    std::reverse(frame.steps.begin(), frame.steps.end());
    for (RefinementStep& step : frame.steps) step.worker = 7;
  }
  EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Threads, 2), recorded.hashes.size());
}

TEST(Decisions, AnotherLevelGivesAnotherState) {
  const Case c{.name = "fitted"};
  Recorded recorded = record(c, 2);
  std::size_t changed = 0;
  for (; changed < recorded.decisions.size(); ++changed) {
    std::vector<RefinementStep>& steps = recorded.decisions[changed].steps;
    const auto last = std::find_if(steps.rbegin(), steps.rend(),
                                   [](const RefinementStep& s) { return s.kind == RefinementStep::Kind::Completed; });
    if (last == steps.rend()) continue;
    steps.erase(std::next(last).base());
    break;
  }
  ASSERT_LT(changed, recorded.decisions.size());
  EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Serial, 1), changed) << "a kept level is part of the state";
}

TEST(Decisions, CountedWorkDecidesAlikeOnAnyThreadsAndInTheSameOrder) {
  const Case c{.name = "fitted"};
  std::vector<FrameDecisions> first;
  for (const int threads : {1, 2, 3}) {
    Stage stage(settings_of(c, ExecutorKind::Threads, threads), 0.2);
    fill(c, stage);
    StepInput input = input_of(c);
    input.record = true;
    input.budget = Budget::work(60);
    std::vector<FrameDecisions> decided(40);
    for (FrameDecisions& frame : decided) {
      stage.world.step(input);
      stage.world.decisions(frame);
    }
    EXPECT_GT(decided.back().steps.size(), 0U);
    if (first.empty()) first = decided;
    EXPECT_EQ(decided, first) << threads;
  }
}

// Independent of the machine: how far each pair comes is counted.
TEST(Decisions, CountedWorkIsDoneAgainToTheBitWithEachContactModel) {
  for (const ContactModel contact : {ContactModel::Fitted, ContactModel::Wrench, ContactModel::Paper}) {
    const Case c{.name = "counted work", .contact = contact};
    Recorded recorded;
    Stage stage(settings_of(c, ExecutorKind::Threads, 2), 0.2);
    fill(c, stage);
    StepInput input = input_of(c);
    input.record = true;
    input.budget = Budget::work(60);
    for (int i = 0; i < c.frames; ++i) {
      recorded.left += stage.world.step(input).pairs_left;
      recorded.decisions.emplace_back();
      stage.world.decisions(recorded.decisions.back());
      recorded.hashes.push_back(stage.world.state_hash());
    }
    EXPECT_GT(recorded.left, 100U) << "nothing was left coarse";
    EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Serial, 1), recorded.hashes.size()) << static_cast<int>(contact);
    EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Threads, 3), recorded.hashes.size()) << static_cast<int>(contact);
  }
}

TEST(Decisions, CompletedStepsAreTheLevelsThatTheReportCounts) {
  const Case c{.name = "fitted"};
  Stage stage(settings_of(c, ExecutorKind::Threads, 3), 0.2);
  fill(c, stage);
  StepInput input = input_of(c);
  input.record = true;
  std::size_t completed = 0;
  std::map<std::uint8_t, std::size_t> of_worker;
  for (int i = 0; i < 60; ++i) {
    input.budget = budget_of(i);
    const FrameReport report = stage.world.step(input);
    FrameDecisions decisions;
    stage.world.decisions(decisions);
    EXPECT_EQ(decisions.frame, report.frame);
    EXPECT_EQ(decisions.active_pairs, simulation::WorldAccess::of(stage.world).outputs.table.size());
    const auto kind = [&](RefinementStep::Kind k) {
      return static_cast<std::size_t>(std::count_if(decisions.steps.begin(), decisions.steps.end(),
                                                    [&](const RefinementStep& s) { return s.kind == k; }));
    };
    EXPECT_EQ(kind(RefinementStep::Kind::Completed), report.jobs_done);
    EXPECT_LE(kind(RefinementStep::Kind::Cut) + kind(RefinementStep::Kind::Full), report.jobs_discarded)
        << "a job that is abandoned is nobody's to note";
    completed += report.jobs_done;
    for (const RefinementStep& step : decisions.steps) ++of_worker[step.worker];
  }
  EXPECT_GT(completed, 40U);
  EXPECT_LE(of_worker.rbegin()->first, 2);
}

TEST(Decisions, AStepThatWasNotRecordedHasNone) {
  Stage stage(settings_of({}, ExecutorKind::Serial, 1), 0.2);
  fill({}, stage);
  FrameDecisions decisions;
  decisions.steps.resize(3);
  stage.world.decisions(decisions);
  EXPECT_EQ(decisions, FrameDecisions{});
  StepInput input = step_of(1.0 / 60);
  input.record = true;
  for (int i = 0; i < 30; ++i) stage.world.step(input);
  stage.world.decisions(decisions);
  EXPECT_GT(decisions.steps.size(), 0U);
  input.record = false;
  stage.world.step(input);
  stage.world.decisions(decisions);
  EXPECT_EQ(decisions, FrameDecisions{});
}

TEST(Decisions, OfAnotherFrameAreRefusedAndOfAnotherSceneAreToldAsSuch) {
  Stage stage(settings_of({}, ExecutorKind::Serial, 1), 0.2);
  fill({}, stage);
  const std::uint64_t before = stage.world.state_hash();
  StepInput input = step_of(1.0 / 60);
  FrameDecisions decisions;
  decisions.frame = 1;
  input.replay = &decisions;
  EXPECT_EQ(stage.world.step(input).status, StepStatus::RefusedReplay);
  EXPECT_EQ(stage.world.state_hash(), before);
  decisions.frame = 0;
  decisions.active_pairs = 12345;
  EXPECT_EQ(stage.world.step(input).status, StepStatus::ReplayDiffers);
  decisions.frame = 1;
  decisions.active_pairs = 0;
  decisions.steps.push_back({4000000000U, 0, RefinementStep::Kind::Completed});
  EXPECT_EQ(stage.world.step(input).status, StepStatus::ReplayDiffers);
}

TEST(Decisions, WhatThePaperKeepsOfManyWorkersNeedsAsMuchRoomOnOne) {
  const Case c{.name = "paper", .contact = ContactModel::Paper};
  const auto settings = [&](std::uint32_t entries, int threads) {
    WorldSettings s = settings_of(c, ExecutorKind::Threads, threads);
    s.max_front_entries = entries;
    return s;
  };
  Stage wide(settings(1U << 16U, 4), 0.2);
  fill(c, wide);
  Stage narrow(settings(64, 1), 0.2);
  fill(c, narrow);
  StepInput input = input_of(c);
  input.record = true;
  StepInput again = input_of(c);
  StepStatus status = StepStatus::Done;
  for (int i = 0; i < 60 && status == StepStatus::Done; ++i) {
    wide.world.step(input);
    FrameDecisions decisions;
    wide.world.decisions(decisions);
    again.replay = &decisions;
    status = narrow.world.step(again).status;
  }
  EXPECT_EQ(status, StepStatus::ReplayDiffers) << "a front without room must be told";
}

TEST(Decisions, AnExplanationTellsEachLevelItsScoreAndWhatWasLeft) {
  const Case c{.name = "fitted"};
  Recorded recorded = record(c, 2);
  Stage stage(settings_of(c, ExecutorKind::Threads, 2), 0.2);
  fill(c, stage);
  StepInput input = input_of(c);
  FrameExplanation explanation;
  std::size_t left = 0;
  std::size_t levels = 0;
  for (std::size_t i = 0; i < recorded.hashes.size(); ++i) {
    input.replay = &recorded.decisions[i];
    input.explain = i % 3 == 0 ? &explanation : nullptr;
    const FrameReport report = stage.world.step(input);
    ASSERT_EQ(stage.world.state_hash(), recorded.hashes[i]) << "explaining changes nothing";
    if (input.explain == nullptr) continue;
    EXPECT_EQ(explanation.frame, i);
    ASSERT_EQ(explanation.pairs.size() + explanation.pairs_apart, report.coarse_pairs);
    ASSERT_EQ(explanation.levels.size(), report.jobs_done);
    std::uint64_t units = 0;
    for (const LevelExplanation& level : explanation.levels) {
      const PairExplanation& pair = explanation.pairs[level.pair];
      EXPECT_GE(level.score, 0.0);
      EXPECT_GT(level.units, 0U);
      EXPECT_LE(level.level, pair.level);
      EXPECT_GT(pair.weight, 0.0);
      if (level.ended) {
        EXPECT_TRUE(pair.apart);
      }
      units += level.units;
    }
    EXPECT_EQ(units, report.work_refine);
    std::size_t refinable = 0;
    for (const PairExplanation& pair : explanation.pairs) {
      EXPECT_LT(pair.a.slot, pair.b.slot);
      refinable += pair.refinable ? 1U : 0U;
      if (pair.refinable) {
        EXPECT_LT(pair.level, pair.deepest);
        EXPECT_GT(pair.next_units, 0U);
      }
    }
    EXPECT_EQ(refinable, report.pairs_left);
    left += refinable;
    levels += explanation.levels.size();
  }
  // The clock decides how many of each there are.
  EXPECT_GT(left + levels, 100U);
}

TEST(Decisions, AnExplanationGivesEachPairTheReasonThatTheStepHad) {
  std::map<PairOutcome, std::size_t> count;
  for (const Case& c : cases()) {
    const Recorded recorded = record(c, 2);
    Stage stage(settings_of(c, ExecutorKind::Threads, 1), 0.2);
    fill(c, stage);
    StepInput input = input_of(c);
    FrameExplanation explanation;
    for (std::size_t i = 0; i < recorded.hashes.size(); ++i) {
      input.replay = &recorded.decisions[i];
      input.explain = &explanation;
      stage.world.step(input);
      count[PairOutcome::KnownApart] += explanation.pairs_apart;
      ASSERT_EQ(explanation.pairs.size(), recorded.outcomes[i].size());
      for (std::size_t k = 0; k < explanation.pairs.size(); ++k) {
        const PairExplanation& pair = explanation.pairs[k];
        ASSERT_EQ(pair.outcome, recorded.outcomes[i][k]) << c.name << ", frame " << i << ", pair " << k;
        EXPECT_EQ(pair.refinable, pair.outcome >= PairOutcome::Reused) << "those are left before their last level";
        ++count[pair.outcome];
      }
      for (const RefinementStep& step : recorded.decisions[i].steps) {
        const PairExplanation& pair = explanation.pairs[step.pair];
        if (step.kind != RefinementStep::Kind::Cut || !pair.refinable) continue;
        EXPECT_TRUE(pair.outcome == PairOutcome::CutOff || (pair.outcome == PairOutcome::Reused && pair.level == 0));
      }
    }
  }
  for (const PairOutcome always :
       {PairOutcome::KnownApart, PairOutcome::FoundApart, PairOutcome::Mandatory, PairOutcome::Unserved})
    EXPECT_GT(count[always], 0U) << static_cast<int>(always);
}

TEST(Decisions, StepsOfWorkersAreMergedByTimeAndOfOneTimeByWorker) {
  simulation::DecisionLog log;
  log.begin(5, 9, 3, 10);
  const auto at = [](int ns) { return SteadyClock::time_point(Nanoseconds(ns)); };
  using Kind = RefinementStep::Kind;
  log.note(2, 8, Kind::Completed, at(1));
  log.note(2, 3, Kind::Cut, at(7));
  log.note(0, 1, Kind::Completed, at(4));
  log.note(0, 2, Kind::Full, at(7));
  log.note(1, 4, Kind::Completed, at(5));
  FrameDecisions decisions;
  log.merge(decisions);
  const std::vector<RefinementStep> expected{
      {8, 2, Kind::Completed}, {1, 0, Kind::Completed}, {4, 1, Kind::Completed}, {2, 0, Kind::Full}, {3, 2, Kind::Cut}};
  EXPECT_EQ(decisions.steps, expected);
  EXPECT_EQ(decisions.frame, 5U);
  EXPECT_EQ(decisions.active_pairs, 9U);
}

}  // namespace
}  // namespace poise
