// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "collision/triangles/polygon_contact.h"
#include "frame/refine/replay_decisions.h"
#include "frame/stages.h"

/// What the ways to refine share: one level of one pair. For refine.cpp and refine_until_cut.cpp alone.
namespace poise::simulation {

/// One refinement of a frame.
struct Refinement {
  WorldState& world;
  const StepInput& input;
  scheduler::FrameFacts facts;
  std::span<WorkerTally> tallies;
  DecisionLog* log = nullptr;  // of a step that is recorded
};

/// How a level ended.
enum class Outcome : std::uint8_t { Completed, Cut, Full };

/// The polygons of a pair, in bounded pieces, as below.
template <class GoOn>
Outcome complete_polygons(const WorldState& world, std::span<collision::FrontPool> pools, const ActivePair& pair,
                          collision::PairLevel& level, collision::LevelContact& found, GoOn&& go_on) {
  const collision::PairFrame frame = frame_of(world, pair);
  const Mat3 rotation = world.buffers.poses[pair.a].rotation;
  collision::PolygonProgress progress;
  collision::begin_polygons(frame, rotation, level, found, progress);
  std::uint32_t left = level.next_units;
  for (;;) {
    const std::uint32_t units = std::min<std::uint32_t>(left, world.settings.policy.quantum_units);
    if (collision::run_polygons(frame, pools, units, progress) == collision::Quantum::Complete) break;
    left -= units;
    if (!go_on(std::min<std::uint32_t>(left, world.settings.policy.quantum_units))) return Outcome::Cut;
  }
  collision::publish_polygons(frame, rotation, progress, level, found);
  return Outcome::Completed;
}

/// One whole level of a pair, in bounded pieces; `go_on(units)` is asked before each piece after the first. What the
/// pair is known by goes on in `level` and `found`, which are its own or copies of them; of the pair itself nothing
/// changes.
template <class GoOn>
Outcome complete_level(const WorldState& world, std::span<collision::FrontPool> pools, const ActivePair& pair,
                       collision::PairLevel& level, collision::LevelContact& found, int worker, GoOn&& go_on) {
  if (level.next_is_polygons()) return complete_polygons(world, pools, pair, level, found, go_on);
  collision::PairFrame frame = frame_of(world, pair);
  const Mat3 rotation = world.buffers.poses[pair.a].rotation;
  if (frame.fitted) {
    const std::size_t next = level.level + 1U;
    collision::set_expected_fit(world.shapes[world.shape_of[pair.a]].deviation_m[next],
                           world.shapes[world.shape_of[pair.b]].deviation_m[next],
                           level.level > 0 ? found.contact.estimated_separation_m : 0.0, frame);
  }
  collision::FrontPool& pool = pools[static_cast<std::size_t>(worker)];
  collision::LevelProgress progress = collision::begin_level(level, pool);
  std::uint32_t left = level.front_entries;
  for (;;) {
    const std::uint32_t units = std::min<std::uint32_t>(left, world.settings.policy.quantum_units);
    const collision::Quantum quantum = collision::run_quantum(frame, pools, worker, units, progress);
    if (quantum == collision::Quantum::Complete) break;
    left -= units;
    const bool full = quantum == collision::Quantum::Full;
    if (full || !go_on(std::min<std::uint32_t>(left, world.settings.policy.quantum_units))) {
      pool.release(progress.mark);
      return full ? Outcome::Full : Outcome::Cut;
    }
  }
  collision::publish_level(frame, rotation, pools, progress, level, found);
  if (!level.refinable() && world.settings.contact != ContactModel::Paper) {
    // Nobody reads the front of a pair that is done but the paper's model.
    pool.release(progress.mark);
    level.front = {};
  }
  if (level.next_is_polygons() && level.refinable()) {
    level.next_units = collision::polygon_units(*frame.a, *frame.b, pools, level.front);
  }
  return Outcome::Completed;
}

inline RefinementStep::Kind kind_of(Outcome outcome) {
  if (outcome == Outcome::Completed) return RefinementStep::Kind::Completed;
  return outcome == Outcome::Cut ? RefinementStep::Kind::Cut : RefinementStep::Kind::Full;
}

inline void note_outcome(const ActivePair& pair, std::uint64_t units, Outcome outcome, WorkerTally& tally) {
  if (outcome == Outcome::Completed) {
    ++tally.jobs;
    tally.units += units;
    if (pair.level.apart) ++tally.separated;
  } else {
    ++tally.discarded;
    if (outcome == Outcome::Full) ++tally.full;
  }
}

/// Refines in the order of the policy until the time before the reserve is over.
void refine_until_cut(Refinement& refinement, TimePoint start, FrameReport& report);

}  // namespace poise::simulation
