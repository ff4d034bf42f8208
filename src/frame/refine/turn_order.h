// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "parallel/ranges.h"
#include "parallel/shared_counters.h"
#include "parallel/unset_vector.h"
#include "poise/scheduler/bands.h"
#include "poise_assert.h"

namespace poise::simulation {

/// The pairs of a refinement in the order of their turns: the best band first, and those of a band as they were put. It
/// is made once a refinement, on all threads, and then workers take blocks of it: what comes next lies side by side, so
/// they can prefetch it. A pair that waits once more goes through scheduler::PriorityBands. Invariant: buffers only
/// grow.
class TurnOrder {
 public:
  /// So that begin() for up to so many pairs allocates nothing.
  void reserve(std::size_t pairs) {
    for (auto* list : {&put_, &pairs_}) list->reserve(pairs);
    for (auto* list : {&turn_put_, &turns_}) list->reserve(pairs);
  }
  /// Room for so many pairs, none of which waits.
  void begin(std::size_t pairs) {
    for (auto* list : {&put_, &pairs_}) list->resize(pairs);
    for (auto* list : {&turn_put_, &turns_}) list->resize(pairs);
    std::fill(turn_put_.begin(), turn_put_.end(), std::uint8_t{0});
    waiting_ = 0;
    taken_.reset();
  }
  /// A pair waits, with this band as its turn: not 0. Any thread, each position once, before make().
  void put(std::size_t position, std::uint32_t pair, std::uint8_t turn) {
    POISE_ASSERT(position < put_.size() && turn != 0 && turn_put_[position] == 0);
    put_[position] = pair;
    turn_put_[position] = turn;
  }
  /// Sorts what was put, in time proportional to the room. From the thread that runs the executor, while no worker
  /// takes.
  void make(parallel::Executor& executor) {
    constexpr std::size_t kLeast = 2048;
    const auto behind_best = [&](std::size_t position) { return scheduler::kBands - 1U - turn_put_[position]; };
    const auto room = [&](std::span<const std::size_t> sizes) {
      std::exclusive_scan(sizes.begin(), sizes.end(), begin_of_, std::uint32_t{0});
      waiting_ = begin_of_[scheduler::kBands - 1];
    };
    parallel::group(executor, put_.size(), kLeast, scheduler::kBands, counts_, behind_best, room,
                    [&](std::size_t position, std::size_t group, std::size_t at) {
                      const std::size_t place = begin_of_[group] + at;
                      pairs_[place] = put_[position];
                      turns_[place] = turn_put_[position];
                    });
  }

  /// Places of the order, consecutive.
  struct Block {
    std::uint32_t begin = 0, end = 0;
  };
  /// The next places, for one of so many workers: at most `most`, and fewer towards the end, so that no worker keeps
  /// many from the others. None when all are taken. Any thread.
  Block take(std::uint32_t most, std::size_t workers) {
    constexpr std::size_t kBlocksOfWorker = 4;  // chosen
    const std::size_t next = taken_.next();
    if (next >= waiting_) return {};  // nothing is written to what all share
    const std::size_t share = (waiting_ - next) / (kBlocksOfWorker * workers);
    most = static_cast<std::uint32_t>(std::clamp<std::size_t>(share, 1, most));
    const auto begin = static_cast<std::uint32_t>(std::min<std::size_t>(taken_.take(most), waiting_));
    return {begin, std::min(begin + most, waiting_)};
  }
  [[nodiscard]] std::uint32_t pair_at(std::uint32_t place) const { return pairs_[place]; }
  [[nodiscard]] std::uint32_t turn_at(std::uint32_t place) const { return turns_[place]; }
  /// The turn at the next place that nobody has taken; 0: there is none. Any thread.
  [[nodiscard]] std::uint32_t next_turn() const {
    const std::size_t next = taken_.next();
    return next < waiting_ ? turns_[next] : 0U;
  }

 private:
  parallel::UnsetVector<std::uint32_t> put_, pairs_;      ///< as they were put; in order
  parallel::UnsetVector<std::uint8_t> turn_put_, turns_;  ///< likewise; 0: none was put there
  std::uint32_t begin_of_[scheduler::kBands] = {};        ///< places: the last group is of those where none was put
  std::uint32_t waiting_ = 0;
  parallel::Tickets taken_;
  std::vector<std::size_t> counts_;  // scratch
};

}  // namespace poise::simulation
