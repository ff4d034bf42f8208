// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "collision/triangles/polygon_contact.h"
#include "frame/coarse.h"
#include "frame/pair_progress.h"
#include "frame/refine/found_contacts.h"
#include "parallel/prefetch.h"

/// One level of one pair, as all ways to refine do it: const inputs, and the progress that the caller owns.
namespace poise::simulation {

/// What refining any pair reads beside the pair. Outlives the frame with workers that are not waited for.
struct PairRefiner {
  SceneView scene;
  ContactModel contact = ContactModel::Fitted;
  std::uint32_t quantum_units = 512;  ///< most expansions between two looks at the clock
};

/// A pair where its bodies are.
struct PosedPair {
  const ActivePair& pair;
  const collision::Pose& a;
  const collision::Pose& b;
};
inline PosedPair posed(const PredictedMotion& motion, const ActivePair& pair) {
  return {pair, motion.poses[pair.a], motion.poses[pair.b]};
}

/// Poses of pairs lie anywhere in memory: prefetched so many pairs ahead.
inline constexpr std::uint32_t kPosesAhead = 3;
/// Prefetches what the first level of a pair some pairs later reads of its bodies.
HWY_INLINE void prefetch_bodies(const SceneView& scene, const PredictedMotion& motion, const ActivePair& pair) {
  for (const std::uint32_t body : {pair.a, pair.b}) {
    parallel::prefetch(motion.poses[body]);
    hwy::Prefetch(&scene.bodies.shape[body]);
  }
}

/// The frame of refinement of a pair, for all its levels.
collision::PairFrame frame_of(const PairRefiner& refiner, const PosedPair& posed);
/// What the next level looks for, by what the last one has found.
inline void look_after(const ActivePair& pair, const collision::PairLevel& level, const collision::LevelContact& found,
                       collision::PairFrame& frame) {
  collision::set_margin(level.level > 0 ? found.reach_m : pair.reach_m, frame);
}

/// How a level ended.
enum class Outcome : std::uint8_t { Completed, Cut, Full };

/// The polygons of a pair, in bounded pieces, as below.
template <class GoOn>
Outcome complete_polygons(const PairRefiner& refiner, std::span<collision::FrontPool> pools, const PosedPair& posed,
                          const collision::PairFrame& frame, collision::PairLevel& level,
                          collision::LevelContact& found, GoOn&& go_on) {
  if (level.level == 0) found = {};
  collision::PolygonProgress progress;
  collision::begin_polygons(frame, posed.a.rotation, level, found, progress);
  std::uint32_t left = level.next_units;
  for (;;) {
    const std::uint32_t units = std::min(left, refiner.quantum_units);
    if (collision::run_polygons(frame, pools, units, progress) == collision::Quantum::Complete) break;
    // What a front of leaves costs is estimated; where it costs more, another piece like this one is to come.
    left = left > units ? left - units : refiner.quantum_units;
    if (!go_on(std::min(left, refiner.quantum_units))) return Outcome::Cut;
  }
  collision::publish_polygons(progress, level, found);
  return Outcome::Completed;
}

/// The manifold points of a level, in bounded pieces; false when it was cut.
template <class GoOn>
bool complete_points(const PairRefiner& refiner, std::span<const collision::FrontPool> pools,
                     const collision::PairFrame& frame, const collision::PairLevel& level,
                     collision::LevelContact& found, GoOn&& go_on) {
  collision::PointsProgress progress = collision::begin_points(frame, level, found);
  std::uint32_t left = collision::points_units(level.point_entries);
  for (;;) {
    const std::uint32_t units = std::min(left, refiner.quantum_units);
    if (!go_on(units)) return false;
    if (collision::run_points(frame, pools, units, progress) == collision::Quantum::Complete) break;
    left -= units;
  }
  collision::publish_points(progress, found);
  return true;
}

/// Is a level followed by the next one at once? Then no more is found of it than that one reads
/// (LevelContact::gaps_only), unless that one is of polygons.
enum class Followed : bool { No, AtOnce };

/// One whole level of a pair, in bounded pieces; `go_on(units)` is asked before each piece after the first. What the
/// pair is known by goes on in `level` and `found`, which are its own or copies of them; `frame` is that of frame_of.
/// The front goes into the pool of `worker`.
template <class GoOn>
Outcome complete_level(const PairRefiner& refiner, std::span<collision::FrontPool> pools, const PosedPair& posed,
                       collision::PairFrame& frame, collision::PairLevel& level, collision::LevelContact& found,
                       int worker, Followed followed, GoOn&& go_on) {
  look_after(posed.pair, level, found, frame);
  if (level.next_is_polygons()) return complete_polygons(refiner, pools, posed, frame, level, found, go_on);
  if (frame.fitted) {
    const std::size_t next = level.level + 1U;
    collision::set_expected_fit(refiner.scene.facts_of(posed.pair.a).deviation_m[next],
                                refiner.scene.facts_of(posed.pair.b).deviation_m[next],
                                level.level > 0 ? found.contact.estimated_separation_m : 0.0, frame);
  }
  collision::FrontPool& pool = pools[static_cast<std::size_t>(worker)];
  const bool last = level.level + 1U == level.deepest && refiner.contact != ContactModel::Paper;
  collision::LevelProgress progress = collision::begin_level(level, found, pool);
  collision::sample_points(frame, level, last, progress);
  progress.sums.gaps_only = followed == Followed::AtOnce && frame.fitted && level.passes_next();
  std::uint32_t left = level.front_entries;
  for (;;) {
    const std::uint32_t units = std::min(left, refiner.quantum_units);
    const collision::Quantum quantum = collision::run_quantum(frame, pools, worker, units, progress);
    if (quantum == collision::Quantum::Complete) break;
    left -= units;
    const bool full = quantum == collision::Quantum::Full;
    if (full || !go_on(std::min(left, refiner.quantum_units))) {
      pool.release(progress.mark);
      return full ? Outcome::Full : Outcome::Cut;
    }
  }
  collision::publish_level(frame, posed.a.rotation, progress, level, found);
  // A deeper level makes the points of this one needless; if none follows in this frame they are made in the end.
  if (found.points_due && !level.refinable() && !complete_points(refiner, pools, frame, level, found, go_on)) {
    pool.release(progress.mark);
    return Outcome::Cut;
  }
  if (!level.refinable() && refiner.contact != ContactModel::Paper) {
    // Nobody reads the front of a pair that is done but the paper's model.
    pool.release(progress.mark);
    level.front = level.points = {};
  }
  if (level.next_is_polygons() && level.refinable()) {
    level.next_units = collision::polygon_units(*frame.a, *frame.b, pools, level.front);
  }
  return Outcome::Completed;
}

/// A level that the next one was to follow at once, as it was before it: where the next one did not come to its end,
/// all is found of this one.
class PassedLevel {
 public:
  PassedLevel() = default;
  PassedLevel(const collision::PairLevel& level, const collision::LevelContact& found, const collision::FrontPool& pool)
      : before_(level),
        mark_(pool.mark()),
        reach_m_(found.reach_m),
        separation_m_(found.contact.estimated_separation_m),
        narrowed_(found.narrowed) {}

  /// Does the level again, which fits as it did. Nothing else may have been added to the pool of `worker` since.
  void complete(const PairRefiner& refiner, std::span<collision::FrontPool> pools, const PosedPair& posed,
                collision::PairFrame& frame, collision::PairLevel& level, collision::LevelContact& found,
                int worker) const;

 private:
  collision::PairLevel before_;
  collision::FrontPool::Mark mark_{};
  double reach_m_ = 0, separation_m_ = 0;
  bool narrowed_ = false;
};

/// Are the manifold points of a pair still to be made, if its deepest completed level counts? `found`: a LevelContact
/// or FoundContact.
template <class Found>
bool points_due(const PairProgress& progress, const Found& found) {
  // A level with none after it has made its points. Asked first, because what was found of most pairs is in no cache.
  if (!progress.level.refinable() || progress.level.level == 0) return false;
  return !progress.apart() && !progress.from_cache() && found.points_due;
}
/// How many entries of its front they are made of, and what goes with a pair.
inline std::uint32_t entries_of_points(const collision::PairLevel& level) {
  constexpr std::uint32_t kEntriesOfPair = 16;  // what a pair takes beside them; chosen
  return level.point_entries + kEntriesOfPair;
}
/// Makes the manifold points of a pair that are due. Its front is still there.
void make_points_due(const PairRefiner& refiner, const PosedPair& posed, const PairProgress& progress,
                     collision::LevelContact& found, std::span<const collision::FrontPool> pools);
/// The same of a pair of a frame.
void make_points_due(const PairRefiner& refiner, const PosedPair& posed, const PairProgress& progress,
                     FoundContacts& found, std::span<const collision::FrontPool> pools, int worker);

/// The next level of a pair that nobody else refines, whatever that costs. `frame` is that of frame_of.
Outcome refine_level(const PairRefiner& refiner, const PosedPair& posed, collision::PairFrame& frame,
                     PairProgress& progress, collision::LevelContact& found, std::span<collision::FrontPool> pools,
                     int worker, Followed followed = Followed::No);

/// The same of a pair of a frame.
Outcome refine_level(const PairRefiner& refiner, const PosedPair& posed, collision::PairFrame& frame,
                     PairProgress& progress, FoundContacts& found, std::span<collision::FrontPool> pools, int worker);

/// Brings a pair to its deepest level, whatever that costs; false when its front did not fit. Of each level
/// `note(units, outcome)` is called.
template <class Note>
bool refine_pair(const PairRefiner& refiner, const PosedPair& posed, PairProgress& progress,
                 collision::LevelContact& found, std::span<collision::FrontPool> pools, int worker, Note&& note) {
  if (progress.refinable() && !progress.full) {
    collision::PairFrame frame = frame_of(refiner, posed);
    PassedLevel passed;
    do {
      const std::uint64_t units = progress.level.next_units;
      const PassedLevel before(progress.level, found, pools[static_cast<std::size_t>(worker)]);
      const Outcome outcome = refine_level(refiner, posed, frame, progress, found, pools, worker, Followed::AtOnce);
      if (outcome == Outcome::Completed && found.gaps_only) passed = before;
      note(units, outcome);
    } while (progress.refinable() && !progress.full);
    if (found.gaps_only) passed.complete(refiner, pools, posed, frame, progress.level, found, worker);
  }
  make_points_due(refiner, posed, progress, found, pools);
  return !progress.full;
}

/// The same of a pair of a frame.
template <class Note>
bool refine_pair(const PairRefiner& refiner, const PosedPair& posed, PairProgress& progress, FoundContacts& found,
                 std::span<collision::FrontPool> pools, int worker, Note&& note) {
  // What backtracking has found out of it is kept already.
  if (!progress.refinable() || progress.full) {
    make_points_due(refiner, posed, progress, found, pools, worker);
    return !progress.full;
  }
  collision::LevelContact& made = found.at_work(progress, worker);
  const bool fits = refine_pair(refiner, posed, progress, made, pools, worker, note);
  found.keep(progress, made, posed.pair.reach_m, worker);
  return fits;
}
inline bool refine_pair(const PairRefiner& refiner, const PosedPair& posed, PairProgress& progress,
                        FoundContacts& found, std::span<collision::FrontPool> pools, int worker) {
  return refine_pair(refiner, posed, progress, found, pools, worker, [](std::uint64_t, Outcome) {});
}

/// As the first of these without notes, and forgets the front. `pool` is empty before and after.
void refine_whole(const PairRefiner& refiner, const PosedPair& posed, PairProgress& progress,
                  collision::LevelContact& found, collision::FrontPool& pool);

}  // namespace poise::simulation
