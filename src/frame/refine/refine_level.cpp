// SPDX-License-Identifier: MIT
#include "frame/refine/refine_level.h"

namespace poise::simulation {

collision::PairFrame frame_of(const PairRefiner& refiner, const PosedPair& posed) {
  const ActivePair& pair = posed.pair;
  const dynamics::BodyStore& bodies = refiner.scene.bodies;
  collision::PairFrame frame = collision::make_pair_frame(*bodies.shape[pair.a], posed.a, *bodies.shape[pair.b],
                                                          posed.b, pair.reach_m, pair.skin_m);
  frame.nearness.wide_m = static_cast<float>(wide_m(pair));
  frame.fitted = refiner.contact == ContactModel::Fitted;
  frame.by_spheres = refiner.contact == ContactModel::Paper;
  return frame;
}

void PassedLevel::complete(const PairRefiner& refiner, std::span<collision::FrontPool> pools, const PosedPair& posed,
                           collision::PairFrame& frame, collision::PairLevel& level, collision::LevelContact& found,
                           int worker) const {
  pools[static_cast<std::size_t>(worker)].release(mark_);
  level = before_;
  found.reach_m = reach_m_;
  found.contact.estimated_separation_m = separation_m_;
  found.narrowed = narrowed_;
  complete_level(refiner, pools, posed, frame, level, found, worker, Followed::No, [](std::uint64_t) { return true; });
}

void make_points_due(const PairRefiner& refiner, const PosedPair& posed, const PairProgress& progress,
                     collision::LevelContact& found, std::span<const collision::FrontPool> pools) {
  if (!points_due(progress, found)) return;
  collision::make_points(frame_of(refiner, posed), pools, progress.level, found);
}

void make_points_due(const PairRefiner& refiner, const PosedPair& posed, const PairProgress& progress,
                     FoundContacts& found, std::span<const collision::FrontPool> pools, int worker) {
  if (!points_due(progress, found.of(progress))) return;
  collision::LevelContact& made = found.at_work(progress, worker);
  collision::make_points(frame_of(refiner, posed), pools, progress.level, made);
  found.keep_points(progress, made.manifold_points, worker);
}

Outcome refine_level(const PairRefiner& refiner, const PosedPair& posed, collision::PairFrame& frame,
                     PairProgress& progress, collision::LevelContact& found, std::span<collision::FrontPool> pools,
                     int worker, Followed followed) {
  const Outcome outcome = complete_level(refiner, pools, posed, frame, progress.level, found, worker, followed,
                                         [](std::uint64_t) { return true; });
  if (outcome == Outcome::Full) progress.full = true;
  return outcome;
}

Outcome refine_level(const PairRefiner& refiner, const PosedPair& posed, collision::PairFrame& frame,
                     PairProgress& progress, FoundContacts& found, std::span<collision::FrontPool> pools, int worker) {
  collision::LevelContact& made = found.at_work(progress, worker);
  const Outcome outcome = refine_level(refiner, posed, frame, progress, made, pools, worker);
  if (outcome == Outcome::Completed) found.keep(progress, made, posed.pair.reach_m, worker);
  return outcome;
}

void refine_whole(const PairRefiner& refiner, const PosedPair& posed, PairProgress& progress,
                  collision::LevelContact& found, collision::FrontPool& pool) {
  pool.clear();
  refine_pair(refiner, posed, progress, found, {&pool, 1}, 0, [](std::uint64_t, Outcome) {});
  pool.clear();
  progress.level.front = progress.level.points = {};
  progress.level.front_entries = 0;
}

}  // namespace poise::simulation
