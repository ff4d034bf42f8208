// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "poise/scheduler/frame_budget.h"
#include "poise/scheduler/refine_queue.h"

/// The loop that refines a host's items, best first, until no job is forecast to end in time. It runs on the host's
/// threads, asks the host what time it is, and knows nothing of what is refined.
namespace poise::scheduler {

/// What one call of a host's job came to.
struct JobOutcome {
  enum class Kind : std::uint8_t {
    Part,       ///< the job was longer than the units that it was allowed; the rest of it comes next
    Completed,  ///< its result counts, and the item can be refined further
    Done,       ///< its result counts, and the item is refined to its end
    Dropped,    ///< no result, and nothing more of this item in this frame
  };
  Kind kind = Kind::Done;
  std::uint64_t units = 0;       ///< that this call did
  std::uint64_t next_units = 0;  ///< Part: that are left of the job; Completed: of the next job
  std::uint32_t next_band = 0;   ///< Completed: priority of the next job
  std::int64_t tail_items = 0;   ///< by how much the items that the tail has to deal with change, e.g. -1: found apart
};

/// What refinement came to on one thread, or on all of them together.
struct RefineCounts {
  std::uint64_t jobs = 0;       ///< whose result counts
  std::uint64_t parts = 0;      ///< calls of the host's job, each between two looks at the clock
  std::uint64_t units = 0;      ///< in all of them
  std::uint64_t dropped = 0;    ///< jobs that gave no result
  std::uint64_t abandoned = 0;  ///< jobs whose next part was not forecast to end in time
  std::uint64_t left = 0;       ///< items that were taken, and whose job was not forecast to end in time
  bool cut = false;             ///< not even the smallest job was forecast to end in time
  Nanoseconds busy{0};          ///< in the host's job
  Nanoseconds longest{0};       ///< part
  Nanoseconds overrun{0};       ///< of a part beyond its forecast, the largest
  TimePoint ended{};            ///< when the last thread returned

  /// Adds what another thread did.
  void add(const RefineCounts& other);
};

/// What a unit of the host's work costs, followed from what it took: an exponential mean. One thread at a time.
class UnitCost {
 public:
  /// Nanoseconds, > 0; anything else counts as 60.
  explicit UnitCost(double first_ns = 60);
  [[nodiscard]] double ns() const { return ns_; }
  /// One frame's counts, under a budget whose jobs had so much overhead. Frames of fewer than `kLeastUnits` tell
  /// nothing.
  void learn(const RefineCounts& counts, double job_overhead_ns);
  static constexpr std::uint64_t kLeastUnits = 16;

 private:
  double ns_;
};

/// The host's work while a thread finds the queue empty and others still have items in hand, which may come back:
/// leave.
struct LeaveWhenIdle {
  bool operator()() const { return false; }
};

/// Refines until nothing is left or no job is forecast to end before the cut. Each of the host's threads calls it with
/// the same queue and budget; it returns what this thread did. Within a frame it may be called again, e.g. after items
/// were added.
///
/// - `quantum_units` (0 counts as 1): a call of the job is given no more units than this, so that no thread is away
/// from
///   the clock for long.
/// - `TimePoint now()`: the host's clock; never goes back. Called once a part.
/// - `JobOutcome job(std::uint32_t item, std::uint64_t units)`: does the item's next job, or `units` of it, or the rest
///   of it that `Part` left. At one time an item is with one thread. It must not throw.
/// - `bool idle()`: called while the queue is empty and other threads have items in hand, which they may give back:
///   false to leave (the default), true to look again (after a yield, say). Nothing is lost by leaving: a thread that
///   gives an item back goes on with it.
///
/// A part never begins unless the time that it is looked at plus its forecast is within the budget's cut, for what the
/// tail has to deal with then. An item whose job does not fit is closed (`left`), and smaller ones behind it may still
/// fit; a job whose next part does not fit is abandoned (`abandoned`), its item closed. Allocates nothing, takes no
/// lock.
template <class Now, class Job, class Idle = LeaveWhenIdle>
RefineCounts refine_until(RefineQueue& queue, const FrameBudget& budget, std::uint64_t quantum_units, Now&& now,
                          Job&& job, Idle&& idle = Idle{}) {
  const std::uint64_t quantum = std::max<std::uint64_t>(quantum_units, 1);
  RefineCounts counts;
  TimePoint at = now();
  const auto admits = [&](std::uint64_t units) {
    return budget.admits(at, std::min(units, quantum), queue.tail_items());
  };
  // One item's job, part by part.
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
      const bool counts_as_result = outcome.kind != JobOutcome::Kind::Dropped;
      ++(counts_as_result ? counts.jobs : counts.dropped);
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
