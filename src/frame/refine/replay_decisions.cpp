// SPDX-License-Identifier: MIT
#include "frame/refine/replay_decisions.h"

#include <algorithm>

#include "frame/budget/degrade.h"
#include "frame/stages.h"
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
    case CacheUse::None:
      break;
  }
  return PairExplanation::CacheUse::None;
}

PairExplanation explained(const WorldState& world, std::size_t index) {
  const ActivePair& pair = world.buffers.pairs[index];
  PairExplanation e;
  e.a = world.bodies.id_of(pair.low());
  e.b = world.bodies.id_of(pair.high());
  e.cached = cached_of(pair.cached);
  e.cached_level = pair.memory.level;
  e.deepest = pair.level.deepest;
  e.polygons = pair.level.polygons;
  e.mandatory = pair.exact;
  if (!pair.refinable()) return e;
  e.cues = world.buffers.cues[index];
  e.weight = scheduler::cue_weight(world.settings.policy, e.cues);
  return e;
}

// Doing a frame's decisions again. What a pair has still to complete is counted down.
class Again {
 public:
  Again(WorldState& world, const StepInput& input, const scheduler::FrameFacts& facts)
      : world_(world), input_(input), facts_(facts), left_(world.buffers.pairs.size(), 0) {
    fits_ = input.replay->active_pairs == left_.size();
    for (const RefinementStep& step : input.replay->steps) {
      if (step.kind != RefinementStep::Kind::Completed) continue;
      if (step.pair < left_.size() && left_[step.pair] <= kPolygonBin) {
        ++left_[step.pair];
      } else {
        fits_ = false;
      }
    }
  }

  bool run() {
    if (input_.explain != nullptr) {
      explain(*input_.explain);
    } else {
      parallel::parallel_for(*world_.executor, left_.size(), kReplayGrain,
                             [&](std::size_t begin, std::size_t end, int worker) {
                               for (std::size_t i = begin; i < end; ++i) {
                                 while (left_[i] > 0 && complete(i, worker)) {
                                 }
                                 forget_front(i, worker);
                               }
                             });
      if (keeps_fronts()) find_room();
    }
    return fits_ && std::all_of(left_.begin(), left_.end(), [](std::uint8_t left) { return left == 0; });
  }

 private:
  bool complete(std::size_t index, int worker) {
    ActivePair& pair = world_.buffers.pairs[index];
    if (!pair.refinable()) return false;
    const std::uint64_t units = pair.level.next_units;
    if (!refine_level(world_, pair, world_.buffers.found[index], worker)) return false;
    --left_[index];
    WorkerTally& tally = world_.buffers.tallies[static_cast<std::size_t>(worker)];
    ++tally.jobs;
    tally.units += units;
    if (pair.level.apart) ++tally.separated;
    return true;
  }

  bool complete_anywhere(std::size_t index) {
    for (int worker = 0; worker < world_.executor->concurrency(); ++worker) {
      world_.buffers.pairs[index].full = false;
      if (complete(index, worker)) return true;
    }
    return false;
  }

  // Only the paper's model reads fronts afterwards.
  [[nodiscard]] bool keeps_fronts() const { return world_.settings.contact == ContactModel::Paper; }

  // A front that had no room beside the others of its worker may have it beside those of another.
  void find_room() {
    for (std::size_t i = 0; i < left_.size(); ++i) {
      while (left_[i] > 0 && complete_anywhere(i)) {
      }
    }
  }

  // The front of a pair is with one worker, or (-1) with any of them.
  void forget_front(std::size_t index, int worker) {
    if (keeps_fronts()) return;
    world_.buffers.pairs[index].level.front = {};
    std::vector<collision::FrontPool>& pools = world_.buffers.pools;
    for (std::size_t w = 0; w < pools.size(); ++w) {
      if (worker < 0 || w == static_cast<std::size_t>(worker)) pools[w].clear();
    }
  }

  void explain(FrameExplanation& explanation) {
    explanation.frame = world_.frame;
    explanation.policy = world_.settings.policy;
    explanation.pairs.clear();
    explanation.levels.clear();
    for (std::size_t i = 0; i < left_.size(); ++i) {
      const auto index = static_cast<std::uint32_t>(i);
      const ActivePair& pair = world_.buffers.pairs[i];
      PairExplanation e = explained(world_, i);
      while (left_[i] > 0 && pair.refinable()) {
        LevelExplanation level{index, Level{0}, pair.level.next_units, score_of(world_, facts_, pair, index), false};
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
        e.next_score = score_of(world_, facts_, pair, index);
      }
      explanation.pairs.push_back(e);
    }
  }

  WorldState& world_;
  const StepInput& input_;
  const scheduler::FrameFacts& facts_;
  std::vector<std::uint8_t> left_;
  bool fits_ = true;
};

}  // namespace

DecisionLog& begin_log(WorldState& world, const scheduler::FrameFacts& facts) {
  if (!world.decisions) world.decisions = std::make_unique<DecisionLog>();
  const FrameBuffers& buffers = world.buffers;
  // Each level of each pair once, and a pair's last one may have been dropped.
  const std::size_t most = buffers.pairs.capacity() * (facts.deepest_level + std::size_t{1});
  world.decisions->begin(world.frame, buffers.pairs.size(), buffers.pools.size(), most);
  return *world.decisions;
}

void log_degraded(const WorldState& world, const Degraded& degraded, DecisionLog& log) {
  log.substeps(static_cast<std::uint32_t>(degraded.substeps));
  for (std::size_t k = 0; k < degraded.pairs_reused; ++k) log.reused(world.buffers.least_seen[k].pair);
}

bool refine_as_recorded(WorldState& world, const StepInput& input, const scheduler::FrameFacts& facts,
                        FrameReport& report) {
  const bool left_out = degrade_as_recorded(world, *input.replay, report.degraded);
  return Again(world, input, facts).run() && left_out;
}

}  // namespace poise::simulation
