// SPDX-License-Identifier: MIT
#include "world/decision_log.h"

#include <algorithm>
#include <array>

namespace poise::simulation {

void DecisionLog::begin(std::uint64_t frame, std::size_t active_pairs, std::size_t workers, std::size_t most_steps) {
  frame_ = frame;
  active_pairs_ = active_pairs;
  known_ = true;
  unfinished_ = false;
  learns_ = false;
  substeps_ = point_iterations_ = crowded_partners_ = 0;
  reused_.clear();
  reused_.reserve(most_steps);
  held_.clear();
  paused_.clear();
  stopped_after_.clear();
  resumed_ = false;
  held_.reserve(most_steps);
  if (lanes_.size() < workers) lanes_.resize(workers);
  for (Lane& lane : lanes_) {
    lane.steps.clear();
    lane.steps.reserve(most_steps);
  }
}

void DecisionLog::merge(FrameDecisions& decisions) const {
  decisions.steps.clear();
  decisions.reused.clear();
  decisions.held.clear();
  decisions.stopped_after.clear();
  decisions.paused.clear();
  decisions.resumed = false;
  decisions.substeps = decisions.point_iterations = decisions.crowded_partners = 0;
  decisions.frame = known_ || unfinished_ ? frame_ : 0;
  decisions.unfinished = unfinished_;
  decisions.learns = known_ && !unfinished_ && learns_;
  decisions.active_pairs = known_ && !unfinished_ ? static_cast<std::uint32_t>(active_pairs_) : 0;
  if (!known_ || unfinished_) return;
  decisions.substeps = substeps_;
  decisions.point_iterations = point_iterations_;
  decisions.crowded_partners = crowded_partners_;
  decisions.reused = reused_;
  decisions.held = held_;
  decisions.stopped_after = stopped_after_;
  decisions.paused = paused_;
  decisions.resumed = resumed_;
  std::sort(decisions.reused.begin(), decisions.reused.end());
  constexpr std::size_t kMostWorkers = 256;
  std::array<std::size_t, kMostWorkers> next{};
  for (;;) {
    std::size_t first = lanes_.size();
    for (std::size_t w = 0; w < lanes_.size(); ++w) {
      if (next[w] == lanes_[w].steps.size()) continue;
      if (first == lanes_.size() || lanes_[w].steps[next[w]].when < lanes_[first].steps[next[first]].when) first = w;
    }
    if (first == lanes_.size()) return;
    const Step& step = lanes_[first].steps[next[first]++];
    decisions.steps.push_back({step.pair, static_cast<std::uint8_t>(first), step.kind});
  }
}

}  // namespace poise::simulation
