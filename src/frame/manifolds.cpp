// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "frame/manifolds.h"
#include "parallel/prefetch.h"
#include "parallel/shared_counters.h"
#include "world/renew_points.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kChunkGrain = 2;
// Bodies and points of pairs lie anywhere in memory: prefetched some pairs ahead.
constexpr std::size_t kPointsAhead = 8;
constexpr std::size_t kFoundAhead = 4;  // of what was found of a pair, its points

// Overlap that is left alone, as a share of the skin. Chosen: keeps contacts closed without being seen.
constexpr double kSlopOfSkin = 1e-4;

PlacedPair placed_pair(const ManifoldsInput& input, const ActivePair& pair) {
  const Shape& shape_b = *input.scene.bodies.shape[pair.b];
  PlacedPair made{input.motion.poses[pair.a], input.motion.poses[pair.b], shape_b.kind == ShapeKind::Plane, 0};
  if (made.plane)
    made.height_m = (made.b.rotation * shape_b.plane_normal).dot(made.b.position_m) + shape_b.plane_offset_m;
  return made;
}

// How many points a pair has in this frame. The first is that of the impact; the others, or the first where it is the
// only one, are the manifold.
std::uint8_t count_points(const ManifoldsInput& input, std::size_t i) {
  const PairProgress& progress = input.levels.progress[i];
  if (progress.apart()) return 0;
  if (progress.from_cache()) return input.table.pairs[i].cached->point_count;
  if (progress.level.level == 0) return progress.exact || coarsest_near(input.motion, input.table.pairs[i]) ? 1 : 0;
  return static_cast<std::uint8_t>(1 + input.levels.found.of(progress).point_count);
}

// Points that this frame has found take the place of those that are cached. Their separations are those found.
void write_points(const ManifoldsInput& input, std::size_t i, PairPoints& made, PointCache& cache) {
  // New points within this many skins of old ones are taken for them: a quarter of the smaller body's radius.
  constexpr double kSameOfSkin = 50;
  const ActivePair& pair = input.table.pairs[i];
  const PairProgress& progress = input.levels.progress[i];
  const FoundContact& found = input.levels.found.of(progress);
  const PlacedPair where = placed_pair(input, pair);
  collision::PairContact coarsest;
  const collision::PairContact& contact = contact_of(input.scene, input.motion, pair, progress, found, coarsest);
  collision::ManifoldPoint impact = collision::impact_point(contact, where.a.rotation);
  // Points are in the middle between the surfaces.
  const std::optional<double> share = share_of_contact(input.motion, pair, progress);
  if (share && *share != 0.5) impact.point_m += ((0.5 - *share) * impact.gap_m) * impact.normal;
  RenewedPoints renewed;
  renewed.found[0] = &impact;
  const std::span<const collision::ManifoldPoint> points = input.levels.found.points_of(found);
  for (std::size_t k = 1; k < made.point_count; ++k) renewed.found[k] = &points[k - 1];
  renewed.count = made.point_count;
  renewed.points = &cache.points[PointCache::begin(made.slot)];
  renewed.forces = &cache.forces[PointCache::begin(made.slot)];
  renewed.old_count = pair.cached->point_count;
  if (renewed.old_count > 0) {
    renewed.old_points = &cache.points[PointCache::begin(pair.cached->slot)];
    renewed.old_forces = &cache.forces[PointCache::begin(pair.cached->slot)];
  }
  renewed.alike_m = kSameOfSkin * pair.skin_m;
  std::array<double, kPointsOfPair> gaps_m;
  renew_points(where, renewed, gaps_m);
  made.impact_gap_m = gaps_m[0];
  made.nearest_m = gaps_m[0];
  for (std::size_t k = 1; k < renewed.count; ++k) made.nearest_m = std::min(made.nearest_m, gaps_m[k]);
  made.looked_m = 0;
}

// May the bodies of a pair close so fast that it is an impact, at any of their points? What its margin was made of says
// so.
bool may_be_fast(const ManifoldsInput& input, std::size_t i) {
  const ActivePair& pair = input.table.pairs[i];
  const SweptBounds& swept = input.motion.swept;
  if (swept.fast(pair.a) || swept.fast(pair.b)) return true;  // their margin is another
  const double dt_s = input.terms.dt_s;
  double closing_m = pair.margin_m - pair.skin_m;
  if (input.scene.bodies.dynamic[pair.a] == 0 || input.scene.bodies.dynamic[pair.b] == 0)
    closing_m -= input.terms.gravity_mps2.norm() * dt_s * dt_s;
  return closing_m > input.still_mps * dt_s;
}

// Do the cached separations of a pair still say for sure whether one of its points is nearer than the margin?
bool knows_separations(const ActivePair& pair, const PairProgress& progress) {
  return progress.from_cache() && std::abs(pair.cached->nearest_m - pair.margin_m) > pair.cached->changed_m();
}

// Prefetches what make_pair() reads of a pair beside the tables.
HWY_INLINE void prefetch_points_of(const ManifoldsInput& input, std::size_t i, PointCache& cache) {
  const ActivePair& pair = input.table.pairs[i];
  const PairProgress& progress = input.levels.progress[i];
  if (progress.apart() || knows_separations(pair, progress)) return;
  for (const std::uint32_t body : {pair.a, pair.b}) parallel::prefetch(input.motion.poses[body]);
  hwy::Prefetch(&input.scene.bodies.shape[pair.b]);
  const bool refined = progress.level.level > 0 && !progress.from_cache();
  if (refined) parallel::prefetch(input.levels.found.of(progress));
  if (pair.cached->slot == kNoSlot) return;
  const std::size_t first = PointCache::begin(pair.cached->slot);
  for (std::size_t p = first; p < first + pair.cached->point_count; ++p) parallel::prefetch(cache.points[p]);
  // Warm starting reads the old forces.
  if (refined) {
    for (const solver::ContactForce& force : cache.forces_of(pair.cached->slot, pair.cached->point_count))
      hwy::Prefetch(&force);
  }
}

HWY_INLINE void prefetch_found_points_of(const ManifoldsInput& input, std::size_t i) {
  const PairProgress& progress = input.levels.progress[i];
  if (progress.found == 0 || progress.apart()) return;
  for (const collision::ManifoldPoint& point : input.levels.found.points_of(input.levels.found.of(progress)))
    hwy::Prefetch(&point);
}

// A ball is touched where the normal from its centre leaves it, however it has turned since: a point that rolled on
// with it would take the load with it and drive it forward. Leaves the separations of new points as they are.
void center_points(const ManifoldsInput& input, const ActivePair& pair, bool turned,
                   std::span<solver::ContactPoint> points) {
  const Mat3 b_in_a = input.motion.poses[pair.a].rotation.transpose() * input.motion.poses[pair.b].rotation;
  for (solver::ContactPoint& point : points) {
    const Vec3 normal = b_in_a * point.normal;
    const double along_m = normal.dot(point.on_a_m);
    point.on_a_m = (turned ? std::copysign(point.on_a_m.norm(), along_m) : along_m) * normal;
  }
}

// Separations of cached points at the poses of this frame.
void update_separations(const ManifoldsInput& input, const ActivePair& pair, PairPoints& made, PointCache& cache) {
  const collision::Pose& a = input.motion.poses[pair.a];
  const collision::Pose& b = input.motion.poses[pair.b];
  const std::span<const solver::ContactPoint> points = cache.points_of(made.slot, made.point_count);
  const Mat3 a_in_b = b.rotation.transpose() * a.rotation;
  const Vec3 from_b = b.rotation.transpose() * (a.position_m - b.position_m);
  made.nearest_m = std::numeric_limits<double>::max();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double gap_m = points[k].plane_b_m - points[k].normal.dot(from_b + a_in_b * points[k].on_a_m);
    made.nearest_m = std::min(made.nearest_m, gap_m);
    if (k == 0) made.impact_gap_m = gap_m;
  }
  made.looked_m = pair.cached->moved_m;
}

void fill_manifold(const ManifoldsInput& input, std::size_t i, const PairPoints& points, solver::Manifold& manifold) {
  const ActivePair& pair = input.table.pairs[i];
  const Material material = input.scene.mixed_material(pair.a, pair.b);
  manifold.a = pair.a;
  manifold.b = pair.b;
  manifold.point_begin = static_cast<std::uint32_t>(PointCache::manifold_begin(points.slot, points.point_count));
  manifold.pair = static_cast<std::uint32_t>(i);
  manifold.point_count = static_cast<std::uint8_t>(PointCache::manifold_count(points.point_count));
  manifold.fast = may_be_fast(input, i);
  manifold.friction = material.friction;
  manifold.restitution = material.restitution;
  manifold.slop_m = kSlopOfSkin * pair.skin_m;
}

// Where the points of pairs go, and the worker that makes them.
struct PointsTo {
  PointCache& cache;
  SlotAllocator& slots;
  int worker;
  bool read = false;  // those of the last step may still be read (CompletedLevels::jobs_left): they stay as they are
};

// A slot that has room for the points of a pair: its own, or another. Points that are changed where they are, of a pair
// on a ball, go there too.
void find_slot(const PairProgress& progress, PairPoints& made, const PointsTo& to) {
  const bool from_cache = progress.from_cache();
  const bool stays = to.read && (!from_cache || progress.on_ball);
  if (made.slot != kNoSlot && PointCache::room_of(made.slot) >= made.point_count && !stays) return;
  const std::uint32_t old = made.slot;
  made.slot = to.slots.take(to.cache, made.point_count, to.worker);
  if (old == kNoSlot) return;
  to.slots.give_back(old, to.worker);
  if (!from_cache) return;
  std::ranges::copy(to.cache.points_of(old, made.point_count), to.cache.points_of(made.slot, made.point_count).begin());
  std::ranges::copy(to.cache.forces_of(old, made.point_count), to.cache.forces_of(made.slot, made.point_count).begin());
}

// Points of one pair, and whether the solver takes them: one of them is nearer than the margin.
void make_points_of(const ManifoldsInput& input, std::size_t i, PairPoints& made, const PointsTo& to) {
  PointCache& cache = to.cache;
  const ActivePair& pair = input.table.pairs[i];
  const PairProgress& progress = input.levels.progress[i];
  const bool from_cache = progress.from_cache();
  find_slot(progress, made, to);
  if (!from_cache) write_points(input, i, made, cache);
  if (progress.on_ball) center_points(input, pair, from_cache, cache.points_of(made.slot, made.point_count));
  if (from_cache && !knows_separations(pair, progress)) {
    update_separations(input, pair, made, cache);
  }
  made.solved = made.nearest_m < pair.margin_m;
  if (made.solved || (from_cache && !pair.cached->solved)) return;
  // It is not solved: no force to start from.
  for (solver::ContactForce& force : cache.forces_of(made.slot, made.point_count)) force = {};
}

// Those of a chunk.
using ChunkManifolds = std::array<solver::Manifold, PairTable::kMostOfChunk>;

// Points of one pair, and its manifold if the solver takes it.
void make_pair(const ManifoldsInput& input, std::size_t i, const PointsTo& to, SolvedCount& count,
               ChunkManifolds& of_chunk, Manifolds& manifolds) {
  const PairProgress& progress = input.levels.progress[i];
  const CachedPair& cached = *input.table.pairs[i].cached;
  PairPoints& made = manifolds.points[i];
  made.slot = cached.slot;
  made.solved = false;
  made.nearest_m = cached.nearest_m;
  made.impact_gap_m = cached.impact_gap_m;
  made.looked_m = cached.looked_m;
  if (progress.refinable()) ++count.left;
  if (progress.cached == CacheUse::Separated) ++count.cached_separations;
  // Of what waits, only what refinement has found out is new.
  if (progress.held && !progress.fresh()) {
    made.point_count = cached.point_count;
    made.solved = cached.solved;
    return;
  }
  made.point_count = count_points(input, i);
  if (made.point_count == 0) {
    count.unused_slots += made.slot != kNoSlot ? 1U : 0U;
    return;
  }
  make_points_of(input, i, made, to);
  if (progress.held) ++count.held_found;
  if (!made.solved || progress.held) return;
  solver::Manifold& manifold = of_chunk[count.solved++];
  fill_manifold(input, i, made, manifold);
  count.any_fast = count.any_fast || manifold.fast;
  count.manifold_points += manifold.point_count;
  if (progress.from_cache()) ++count.cached_contacts;
  ++count.levels[progress.by_polygons() ? kPolygonBin : progress.solved_level()];
}

// All pairs, chunk by chunk.
void make_points(const ManifoldsInput& input, PointCache& cache, Manifolds& manifolds, parallel::Executor& executor) {
  const PairTable& table = input.table;
  manifolds.solved_of_chunk.assign(table.chunks(), SolvedCount{});
  parallel::reserve_anew(manifolds.points, table.capacity());
  manifolds.points.resize(table.size());
  parallel::reserve_anew(manifolds.of_chunk, table.capacity());
  manifolds.of_chunk.resize(table.size());
  const auto workers = static_cast<std::size_t>(executor.concurrency());
  bool read = input.levels.jobs_left;
  if (read && SlotAllocator::grows(cache, table.size(), workers)) {
    // What they read cannot stay where it is.
    executor.settle();
    read = false;
  }
  // Any pair may gain points in any frame.
  manifolds.slots.begin(cache, table.size(), table.capacity(), executor);
  const bool distant = table.size() > parallel::kPairsAtHand;
  parallel::Tickets places;
  parallel::parallel_for(executor, table.chunks(), kChunkGrain, [&](std::size_t first, std::size_t past, int worker) {
    const PointsTo to{cache, manifolds.slots, worker, read};
    for (std::size_t chunk = first; chunk < past; ++chunk) {
      SolvedCount& count = manifolds.solved_of_chunk[chunk];
      ChunkManifolds of_chunk;
      const std::size_t end = table.end_of(chunk);
      for (std::size_t i = table.begin_of(chunk); i < end; ++i) {
        if (distant && i + 2 * kPointsAhead < end) parallel::prefetch(*table.pairs[i + 2 * kPointsAhead].cached);
        if (distant && i + kPointsAhead < end) prefetch_points_of(input, i + kPointsAhead, cache);
        if (distant && i + kFoundAhead < end) prefetch_found_points_of(input, i + kFoundAhead);
        make_pair(input, i, to, count, of_chunk, manifolds);
      }
      count.begin = static_cast<std::uint32_t>(places.take(count.solved));
      std::copy_n(of_chunk.begin(), count.solved, manifolds.of_chunk.begin() + count.begin);
    }
  });
  manifolds.slots.end(cache);
}

// The manifolds one after another in canonical order, and their colours.
void list_manifolds(const ManifoldsInput& input, Manifolds& manifolds, FrameReport& report,
                    parallel::Executor& executor) {
  const PairTable& table = input.table;
  std::uint32_t solved = 0;
  manifolds.manifold_points = 0;
  manifolds.held_found = 0;
  manifolds.impacts = false;
  manifolds.unused_slots = 0;
  report.cached_separations += table.apart_count();
  for (SolvedCount& count : manifolds.solved_of_chunk) {
    count.before = solved;
    solved += count.solved;
    manifolds.manifold_points += count.manifold_points;
    manifolds.held_found += count.held_found;
    manifolds.impacts = manifolds.impacts || count.any_fast;
    manifolds.unused_slots += count.unused_slots;
    report.pairs_left += count.left;
    report.cached_separations += count.cached_separations;
    report.cached_contacts += count.cached_contacts;
    for (std::size_t level = 0; level < count.levels.size(); ++level)
      report.level_histogram[level] += count.levels[level];
  }
  // All grow with the pairs, so that later frames that solve a larger share of them need no new memory.
  parallel::reserve_anew(manifolds.manifolds, table.capacity());
  parallel::reserve_anew(manifolds.edges, table.capacity());
  manifolds.coloring.reserve(table.capacity());
  manifolds.manifolds.resize(solved);
  manifolds.edges.resize(solved);
  const std::vector<std::uint8_t>& dynamic = input.scene.bodies.dynamic;
  parallel::parallel_for(executor, table.chunks(), kChunkGrain, [&](std::size_t first, std::size_t past, int) {
    for (std::size_t chunk = first; chunk < past; ++chunk) {
      const SolvedCount& count = manifolds.solved_of_chunk[chunk];
      for (std::uint32_t k = 0; k < count.solved; ++k) {
        const solver::Manifold& manifold = manifolds.of_chunk[count.begin + k];
        manifolds.manifolds[count.before + k] = manifold;
        manifolds.edges[count.before + k] = {manifold.a, manifold.b, dynamic[manifold.a] != 0, dynamic[manifold.b] != 0,
                                             solver::rank_of(manifold.point_count)};
      }
    }
  });
  manifolds.coloring.color(manifolds.edges, input.scene.bodies.slot_count(), executor);
  report.contact_pairs = solved;
  report.colors_full = solved - manifolds.coloring.shared_begin();
}

}  // namespace

std::optional<double> share_of_contact(const PredictedMotion& motion, const ActivePair& pair,
                                       const PairProgress& progress) {
  const BodyBounds& a = motion.body_bounds[pair.a];
  const BodyBounds& b = motion.body_bounds[pair.b];
  // Corners of polygons stand on a plane themselves; all else is in the middle.
  if (progress.level.level > 0) return b.plane && progress.by_polygons() ? 0.0 : 0.5;
  if (a.place != BodyBounds::Place::Ball) return std::nullopt;
  // At the end of the ball.
  if (b.plane) return 0.0;
  if (b.place != BodyBounds::Place::Ball) return std::nullopt;
  return a.root_radius_m / (a.root_radius_m + b.root_radius_m);
}

const collision::PairContact& contact_of(const SceneView& scene, const PredictedMotion& motion, const ActivePair& pair,
                                         const PairProgress& progress, const FoundContact& found,
                                         collision::PairContact& coarsest) {
  if (progress.level.level > 0 || progress.exact) return found.contact;
  const auto placed = [&](std::uint32_t slot) {
    return collision::PlacedRoot{scene.bodies.shape[slot].get(), motion.body_bounds[slot].root_center_m,
                                 motion.poses[slot].position_m};
  };
  const Shape& shape_b = *scene.bodies.shape[pair.b];
  if (shape_b.kind == ShapeKind::Tree) {
    coarsest = collision::coarsest_contact(placed(pair.a), placed(pair.b));
  } else {
    const Vec3 normal = motion.poses[pair.b].rotation * shape_b.plane_normal;
    const double height = normal.dot(motion.poses[pair.b].position_m) + shape_b.plane_offset_m;
    coarsest = collision::coarsest_plane_contact(placed(pair.a), normal, height);
  }
  return coarsest;
}

void make_manifolds(const ManifoldsInput& input, PointCache& points, Manifolds& manifolds, FrameReport& report,
                    parallel::Executor& executor) {
  make_points(input, points, manifolds, executor);
  list_manifolds(input, manifolds, report, executor);
}

}  // namespace poise::simulation
