// SPDX-License-Identifier: MIT
#include "poise/scheduler/rounds.h"

#include <algorithm>

namespace poise::scheduler {
namespace {

// Heap order: the front is the largest score, and of equals the smallest pair.
bool later(const Candidate& x, const Candidate& y) {
  if (x.score != y.score) return x.score < y.score;
  return x.pair > y.pair;
}

}  // namespace

void RoundSelector::begin_frame(std::uint64_t budget_units, std::size_t expected_candidates,
                                std::uint32_t round_pairs) {
  heap_.clear();
  if (heap_.capacity() < expected_candidates) heap_.reserve(expected_candidates + expected_candidates / 2);
  round_.clear();
  round_pairs_ = std::max(round_pairs, 1U);
  round_.reserve(round_pairs_);
  budget_ = budget_units;
  charged_ = 0;
}

void RoundSelector::add(const Candidate& candidate) {
  heap_.push_back(candidate);
  std::push_heap(heap_.begin(), heap_.end(), later);
}

std::span<const Candidate> RoundSelector::next_round() {
  round_.clear();
  // The rest is for what this round makes possible: were all of it spent at once, the first level of many pairs would
  // come before the second of any, frame after frame.
  const std::uint64_t left = budget_ - charged_;
  const std::uint64_t share = left - left / 2;
  const std::uint64_t begun = charged_;
  while (!heap_.empty() && round_.size() < round_pairs_ && charged_ - begun < share) {
    std::pop_heap(heap_.begin(), heap_.end(), later);
    const Candidate best = heap_.back();
    heap_.pop_back();
    if (best.units > budget_ - charged_) continue;
    charged_ += best.units;
    round_.push_back(best);
  }
  return round_;
}

}  // namespace poise::scheduler
