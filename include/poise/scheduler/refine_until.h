// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "poise/scheduler/frame_budget.h"
#include "poise/scheduler/refine_queue.h"

/// The loop that refines a host's items, best first, until no job is forecast to end in time. It runs on the host's
/// threads, reads the host's clock, and does not depend on what an item is.
namespace poise::scheduler {

/// The result of one call of a host's job.
struct JobOutcome {
  enum class Kind : std::uint8_t {
    Part,       ///< the job has more units than the call was allowed; the rest follows
    Completed,  ///< the result counts, and the item has another job
    Done,       ///< the result counts, and the item is fully refined
    Discarded,  ///< discarded: no result, and no further job of this item in this frame
  };
  Kind kind = Kind::Done;
  std::uint64_t units = 0;       ///< done by this call
  std::uint64_t next_units = 0;  ///< Part: units left of the job; Completed: units of the next job
  std::uint32_t next_band = 0;   ///< Completed: priority of the next job
  std::int64_t tail_items = 0;   ///< change of the number of items that the tail has to process, e.g. -1 for a pair
                                 ///< found separated
};

/// Counts of refinement on one thread, or summed over threads.
struct RefineCounts {
  std::uint64_t jobs = 0;       ///< jobs with a result
  std::uint64_t parts = 0;      ///< calls of the host's job, each between two readings of the clock
  std::uint64_t units = 0;      ///< units of all calls
  std::uint64_t discarded = 0;  ///< discarded jobs
  std::uint64_t abandoned = 0;  ///< jobs whose next part was not forecast to end in time
  std::uint64_t left = 0;       ///< items taken whose job was not forecast to end in time
  bool cut = false;             ///< not even the smallest job was forecast to end in time
  Nanoseconds busy{0};          ///< total duration of the calls
  Nanoseconds longest{0};       ///< duration of the longest call
  Nanoseconds overrun{0};       ///< largest excess of a call over its forecast
  TimePoint ended{};            ///< when the last thread returned

  /// Adds the counts of another thread.
  void add(const RefineCounts& other);
};

/// Cost of a unit of the host's work, tracked as an exponential mean. One thread at a time.
class UnitCost {
 public:
  /// Starts at `first_ns`, nanoseconds, > 0; anything else counts as 60.
  explicit UnitCost(double first_ns = 60);
  /// The current cost of a unit, nanoseconds.
  [[nodiscard]] double ns() const { return ns_; }
  /// Learns from one frame's counts; `job_overhead_ns` is FrameBudget::job_overhead_ns. Frames of fewer than
  /// `kLeastUnits` units are ignored.
  void learn(const RefineCounts& counts, double job_overhead_ns);
  static constexpr std::uint64_t kLeastUnits = 16;

 private:
  double ns_;
};

/// Default for a thread that finds the queue empty while others still hold items, which may return to the queue: it
/// leaves.
struct LeaveWhenIdle {
  bool operator()() const { return false; }
};

/// Refines until nothing is left or no job is forecast to end before the cut. Each of the host's threads calls it with
/// the same queue and budget; it returns the counts of this thread. It may be called again within a frame, e.g. after
/// items were added.
///
/// - `quantum_units` (0 counts as 1): most units of one call of the job. It bounds the time between two readings of the
///   clock.
/// - `TimePoint now()`: the host's clock; must not go back. Called once a part.
/// - `JobOutcome job(std::uint32_t item, std::uint64_t units)`: does at most `units` of the item's next job, or of the
///   rest that `Part` left. At any time at most one thread works on an item. Must not throw.
/// - `bool idle()`: called while the queue is empty and other threads hold items, which they may give back. Returns
///   false to leave (the default) or true to look again (e.g. after a yield). No work is lost by leaving: a thread that
///   gives an item back continues with it.
///
/// A part never begins unless the last reading of the clock plus the part's forecast is within the budget's cut, for
/// the current number of items of the tail. An item whose job does not fit is closed (`left`), and smaller ones behind
/// it may still fit. A job whose next part does not fit is abandoned (`abandoned`), and its item is closed. Allocates
/// nothing and takes no lock.
template <class Now, class Job, class Idle = LeaveWhenIdle>
RefineCounts refine_until(RefineQueue& queue, const FrameBudget& budget, std::uint64_t quantum_units, Now&& now,
                          Job&& job, Idle&& idle = Idle{}) {
  const std::uint64_t quantum = std::max<std::uint64_t>(quantum_units, 1);
  RefineCounts counts;
  TimePoint at = now();
  const auto admits = [&](std::uint64_t units) {
    return budget.admits(at, std::min(units, quantum), queue.tail_items());
  };
  // Does one item's job, part by part.
  const auto do_job = [&](std::uint32_t item) {
    for (std::uint64_t left = queue.units_of(item);;) {
      const std::uint64_t units = std::min(left, quantum);
      const TimePoint begun = at;
      const JobOutcome outcome = job(item, units);
      at = now();
      const Nanoseconds took = at - begun;
      ++counts.parts;
      counts.units += outcome.units;
      counts.busy += took;
      counts.longest = std::max(counts.longest, took);
      counts.overrun = std::max(counts.overrun, took - budget.job_cost(units));
      queue.change_tail(outcome.tail_items);
      if (outcome.kind == JobOutcome::Kind::Part) {
        left = outcome.next_units;
        if (admits(left)) continue;
        ++counts.abandoned;
        return queue.close(item);
      }
      const bool counts_as_result = outcome.kind != JobOutcome::Kind::Discarded;
      ++(counts_as_result ? counts.jobs : counts.discarded);
      if (outcome.kind != JobOutcome::Kind::Completed) return queue.close(item);
      return queue.give_back(item, outcome.next_band, outcome.next_units);
    }
  };
  for (;;) {
    if (!admits(queue.least_units())) {
      counts.cut = queue.open() > 0;
      break;
    }
    const std::uint32_t item = queue.take();
    if (item == RefineQueue::kNone) {
      if (queue.open() == 0 || !idle()) break;
      at = now();
    } else if (admits(queue.units_of(item))) {
      do_job(item);
    } else {
      ++counts.left;
      queue.close(item);
      at = now();
    }
  }
  counts.ended = at;
  return counts;
}

}  // namespace poise::scheduler
