// SPDX-License-Identifier: MIT
#include "frame/refine/replay_decisions.h"

#include <algorithm>

#include "frame/budget/degrade.h"
#include "frame/budget/hold.h"
#include "frame/refine/pair_cues.h"
#include "frame/refine/rank.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kReplayGrain = 8;

PairExplanation::CacheUse cached_of(CacheUse cached) {
  switch (cached) {
    case CacheUse::Separated:
      return PairExplanation::CacheUse::Separated;
    case CacheUse::Points:
      return PairExplanation::CacheUse::Points;
    case CacheUse::Expired:
      return PairExplanation::CacheUse::Expired;
    case CacheUse::Parted:
      return PairExplanation::CacheUse::Parted;
    case CacheUse::None:
      break;
  }
  return PairExplanation::CacheUse::None;
}

PairExplanation explained(const RefineInput& input, const CompletedLevels& levels, std::size_t index) {
  const ActivePair& pair = input.table.pairs[index];
  const PairProgress& progress = levels.progress[index];
  PairExplanation e;
  e.a = input.scene.bodies.id_of(pair.low());
  e.b = input.scene.bodies.id_of(pair.high());
  e.cached = cached_of(progress.cached);
  e.cached_level = progress.cached_level;
  e.deepest = progress.level.deepest;
  e.polygons = progress.level.polygons;
  e.mandatory = progress.exact;
  if (!progress.refinable()) return e;
  e.cues = levels.cues[index];
  e.weight = scheduler::cue_weight(input.policy, e.cues);
  return e;
}

// Doing a frame's decisions again. What a pair has still to complete is counted down.
class Replay {
 public:
  Replay(const RefineInput& input, std::span<collision::FrontPool> pools, const scheduler::FrameFacts& facts,
         CompletedLevels& levels, parallel::Executor& executor)
      : input_(input),
        pools_(pools),
        facts_(facts),
        levels_(levels),
        executor_(executor),
        left_(input.table.size(), 0) {
    const FrameDecisions& decisions = *input.step.replay;
    fits_ = decisions.active_pairs == left_.size();
    for (const RefinementStep& step : decisions.steps) {
      if (step.kind != RefinementStep::Kind::Completed) continue;
      if (step.pair < left_.size() && left_[step.pair] <= kPolygonBin) {
        ++left_[step.pair];
      } else {
        fits_ = false;
      }
    }
  }

  bool run() {
    if (input_.step.explain != nullptr) {
      explain(*input_.step.explain);
      note_stops();
      for (std::size_t i = 0; i < left_.size(); ++i)
        input_.step.explain->pairs[i].outcome = outcome_of(levels_.progress[i]);
    } else {
      parallel::parallel_for(executor_, left_.size(), kReplayGrain,
                             [&](std::size_t begin, std::size_t end, int worker) {
                               for (std::size_t i = begin; i < end; ++i) {
                                 while (left_[i] > 0 && complete(i, worker)) {
                                 }
                                 forget_front(i, worker);
                               }
                             });
      if (keeps_fronts()) complete_elsewhere();
      note_stops();
    }
    if (keeps_fronts()) make_points_left(input_, pools_, levels_, executor_);
    return fits_ && std::all_of(left_.begin(), left_.end(), [](std::uint8_t left) { return left == 0; });
  }

 private:
  bool complete(std::size_t index, int worker) {
    PairProgress& pair = levels_.progress[index];
    if (!pair.refinable()) return false;
    const std::uint64_t units = pair.level.next_units;
    const PosedPair placed = posed(input_.motion, input_.table.pairs[index]);
    collision::PairFrame frame = frame_of(input_.refiner(), placed);
    const Outcome outcome = refine_level(input_.refiner(), placed, frame, pair, levels_.found, pools_, worker);
    if (outcome != Outcome::Completed) return false;
    --left_[index];
    note_outcome(pair.level.apart, units, outcome, levels_.tallies[static_cast<std::size_t>(worker)]);
    return true;
  }

  bool complete_anywhere(std::size_t index) {
    for (int worker = 0; worker < executor_.concurrency(); ++worker) {
      levels_.progress[index].full = false;
      if (complete(index, worker)) return true;
    }
    return false;
  }

  // Only the paper's model reads fronts afterwards.
  [[nodiscard]] bool keeps_fronts() const { return input_.terms.contact == ContactModel::Paper; }

  // A front that did not fit beside the others of its worker may fit beside those of another.
  void complete_elsewhere() {
    for (std::size_t i = 0; i < left_.size(); ++i) {
      while (left_[i] > 0 && complete_anywhere(i)) {
      }
    }
  }

  // The front of a pair is with one worker, or (-1) with any of them.
  void forget_front(std::size_t index, int worker) {
    if (keeps_fronts()) return;
    make_points_due(input_.refiner(), posed(input_.motion, input_.table.pairs[index]), levels_.progress[index],
                    levels_.found, pools_, std::max(worker, 0));
    levels_.progress[index].level.front = levels_.progress[index].level.points = {};
    for (std::size_t w = 0; w < pools_.size(); ++w) {
      if (worker < 0 || w == static_cast<std::size_t>(worker)) pools_[w].clear();
    }
  }

  // What the decisions say of levels that were begun in vain.
  void note_stops() {
    for (const RefinementStep& step : input_.step.replay->steps) {
      if (step.pair >= left_.size() || step.kind == RefinementStep::Kind::Completed) continue;
      PairProgress& pair = levels_.progress[step.pair];
      if (step.kind == RefinementStep::Kind::Cut) pair.stop_for_time();
      if (step.kind == RefinementStep::Kind::Full) pair.full = true;
    }
  }

  double next_score(std::size_t i, PairProgress& pair) {
    const auto index = static_cast<std::uint32_t>(i);
    const double score = score_of(input_, facts_, levels_.cues[i], pair, levels_.found.of(pair).contact, index);
    pair.turn = turn_at(scheduler::band_of(input_.policy, score));
    return score;
  }

  void explain(FrameExplanation& explanation) {
    explanation.frame = input_.frame;
    explanation.policy = input_.policy;
    explanation.pairs.clear();
    explanation.pairs_apart = input_.table.apart_count();
    explanation.levels.clear();
    for (std::size_t i = 0; i < left_.size(); ++i) {
      const auto index = static_cast<std::uint32_t>(i);
      PairProgress& pair = levels_.progress[i];
      PairExplanation e = explained(input_, levels_, i);
      if (pair.refinable()) pair.seen = seen_band(input_.policy, levels_.cues[i]);
      while (left_[i] > 0 && pair.refinable()) {
        LevelExplanation level{index, Level{0}, pair.level.next_units, next_score(i, pair), false};
        if (!complete_anywhere(i)) break;
        level.level = pair.level.level;
        level.ended = pair.level.apart;
        explanation.levels.push_back(level);
      }
      forget_front(i, -1);
      e.level = pair.level.level;
      e.apart = pair.level.apart;
      e.refinable = pair.refinable();
      if (e.refinable) {
        e.next_units = pair.level.next_units;
        e.next_score = next_score(i, pair);
        if (scheduler::left_out(input_.policy, e.next_score) && pair.stop == Stop::None) pair.stop = Stop::Unseen;
      }
      explanation.pairs.push_back(e);
    }
  }

  const RefineInput& input_;
  std::span<collision::FrontPool> pools_;
  const scheduler::FrameFacts& facts_;
  CompletedLevels& levels_;
  parallel::Executor& executor_;
  std::vector<std::uint8_t> left_;
  bool fits_ = true;
};

}  // namespace

void log_degraded(const CompletedLevels& levels, const Degraded& degraded, DecisionLog& log) {
  log.substeps(static_cast<std::uint32_t>(degraded.substeps));
  for (const std::uint32_t pair : levels.reused) log.reused(pair);
  log.held(levels.held.roots);
}

bool refine_as_recorded(const RefineInput& input, std::span<collision::FrontPool> pools,
                        const scheduler::FrameFacts& facts, CompletedLevels& levels, FrameReport& report,
                        parallel::Executor& executor) {
  bool left_out = degrade_as_recorded(input, *input.step.replay, levels, report.degraded);
  left_out = hold_as_recorded(input, input.step.replay->held, levels, report.degraded, executor) && left_out;
  if (input.step.explain != nullptr) report.cues_refused = fill_all_cues(input, levels, executor);
  return Replay(input, pools, facts, levels, executor).run() && left_out;
}

}  // namespace poise::simulation
