// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "poise/scheduler/forecast.h"
#include "poise/step.h"

namespace poise::simulation {

/// What the time forecasts take from one frame to the next beside their coefficients. Not part of the state.
struct TimeFacts {
  std::uint64_t frames = 0;                             ///< learned from
  std::uint64_t candidate_pairs = 0, active_pairs = 0;  ///< of the last frame under a deadline
  double iterations_a_substep = 0;    ///< point iterations of the contact solver that a substep is likely to want
  Nanoseconds planning{0};            ///< FrameReport::planning of the last frame that was forecast infeasible
  std::uint64_t load = 0;             ///< of the last frame: bodies that were stepped, and their pairs
  double ns_of_load = 0;              ///< what one of these wants of a frame, with its refinement; learned
  std::uint64_t manifold_points = 0;  ///< of the last frame: point iterations that a substep makes at least
  scheduler::TailWork tail_work;      ///< of this frame; its contacts are those that were expected
  Nanoseconds iterated{0};            ///< of this frame: what point iterations beyond one a substep took; and
  SteadyClock::time_point iterations_end{};  ///< when they ended; if none were to end in time, 0
  scheduler::TailWork head_work;
  int no_turns = 0;  ///< so many steps without a look for islands that could take turns
};

/// Moves what something is expected to cost towards what it took, and to no more than four times as much: the machine
/// may have been in between.
inline void follow(double measured_ns, double& cost_ns) {
  constexpr double kMostOfExpected = 4, kNewShare = 0.2;  // chosen
  cost_ns += kNewShare * (std::min(measured_ns, kMostOfExpected * cost_ns) - cost_ns);
}

/// What a node-pair expansion takes, learned.
struct UnitCost {
  double ns = 60;          ///< a prior, replaced by what is measured
  double busy_ns = 0;      ///< of frames too small to tell by themselves
  std::uint64_t done = 0;  ///< units of these

  /// A frame took so long for so many. What few units take is told by several frames: where each is thought to be too
  /// dear, few are all that there is time for, and nothing would be learned any more.
  void learn(double frame_busy_ns, std::uint64_t units) {
    constexpr std::uint64_t kLeastUnits = 100;  // chosen
    busy_ns += frame_busy_ns;
    done += units;
    if (done < kLeastUnits) return;
    follow(busy_ns / static_cast<double>(done), ns);
    busy_ns = 0;
    done = 0;
  }
};

/// What it takes to bring a pair of those that can be refined to its end, by all workers together: in the order of
/// memory, or by score with its ranking; learned. What the order that was not taken would have cost is told from how
/// the two compare.
struct RefinementCost {
  double in_order_ns = 0;  ///< 0: not known
  double by_score_ns = 1000;
  double order_share = 0.8;  ///< the first of the second: a prior, replaced where one follows the other
  double last_ns = 0;
  bool last_in_order = false;

  /// Is it told by so many pairs? Those that the order of memory has left over of `refinable` are refined by score, and
  /// most of the time of a few is not their own.
  [[nodiscard]] static bool tells(std::int64_t pairs, std::int64_t refinable = 0) {
    constexpr std::int64_t kLeastPairs = 16, kLeastShare = 8;  // an eighth; chosen
    return pairs >= kLeastPairs && kLeastShare * pairs >= refinable;
  }
  /// So much was measured.
  void learn(double measured_ns, bool in_order) {
    constexpr double kLeastShare = 0.1, kNewShare = 0.3;  // chosen
    if (last_ns > 0 && last_in_order != in_order) {
      const double share = in_order ? measured_ns / last_ns : last_ns / measured_ns;
      order_share += kNewShare * (std::clamp(share, kLeastShare, 1.0) - order_share);
    }
    last_ns = measured_ns;
    last_in_order = in_order;
    const double ordered_ns = in_order ? measured_ns : order_share * measured_ns;
    if (in_order_ns == 0) in_order_ns = ordered_ns;
    follow(ordered_ns, in_order_ns);
    follow(in_order ? measured_ns / order_share : measured_ns, by_score_ns);
  }
};

/// Forecasts of what the parts of a frame take, learned from the frames before. Not part of the state.
struct Forecasts {
  scheduler::TailForecast tail;
  scheduler::TrackedQuantile margin;
  scheduler::DurationForecast host_work;
  scheduler::TailForecast head;  ///< of what comes before refinement; its contacts are the active pairs
  scheduler::TailForecast rest;  ///< of what comes after the iterations of resting contact
  TimeFacts times;
  double solved_share = 1;  ///< of the pairs that are not separated; learned
  UnitCost unit_cost;
  double iteration_ns = 10;  ///< likewise of a point iteration beyond one a substep, by all workers together
  RefinementCost pair_cost;
  double entry_cost_ns = 12;  ///< likewise of making contact points, an entry of a front, by all workers together
  double rank_cost_ns = 30;   ///< likewise of ranking a pair, by all workers together
};

}  // namespace poise::simulation
