// SPDX-License-Identifier: MIT
#include "frame/coarse.h"

#include <memory>

#include "collision/triangles/polygon_contact.h"
#include "frame/ccd/swept.h"
#include "parallel/prefetch.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// Refinement looks this much of the smaller body beyond what may touch in the step, so that what it finds holds while
// the bodies move so far.
constexpr double kReachOfSize = 6e-3;
// Cached points that are too old to be sure of are still used until the bodies have moved this much of the smaller one.
// Measured on a frictionless pile whose budget goes off for 60 frames: at a tenth it sinks by a fifth and is thrown up
// again, at a half it stays within 2 % of its height.
constexpr double kHoldOfSize = 0.5;
// Two bodies that were separated count so as long as they cannot have come to overlap by more than this much of the
// smaller one: nearer to the truth than level 0, which would often hold them where nothing touches. Chosen; with 0.02
// and 0.5 a heap whose budget was too small stands as high and is known as soon.
constexpr double kSinkOfSize = 0.1;
// Where no two nodes come within this much of the smaller body more, a pair that was found separated stays so for that
// much longer.
constexpr double kWideOfSize = 4 * kReachOfSize;
constexpr std::size_t kCandidateGrain = PairTable::kMostOfChunk;

// Goes through the cached pairs of the last step beside this frame's, both in canonical order, and marks those that it
// meets.
class CachedPairs {
 public:
  CachedPairs(std::span<const CachedPair> cached, parallel::UnsetVector<std::uint8_t>& still_active, std::uint32_t low,
              std::uint32_t high)
      : begin_(cached.begin()),
        at_(std::lower_bound(cached.begin(), cached.end(), std::pair(low, high), before)),
        end_(cached.end()),
        still_active_(still_active) {}
  void take(std::uint32_t low, std::uint32_t high, CachedPair& into) {
    while (at_ != end_ && before(*at_, {low, high})) ++at_;
    if (at_ != end_ && at_->low == low && at_->high == high) {
      still_active_[static_cast<std::size_t>(at_ - begin_)] = 1;
      into = *at_;
      return;
    }
    CachedPair& none = *std::construct_at(&into);
    none.low = low;
    none.high = high;
  }

 private:
  using Key = std::pair<std::uint32_t, std::uint32_t>;
  static bool before(const CachedPair& pair, const Key& key) { return Key(pair.low, pair.high) < key; }
  std::span<const CachedPair>::iterator begin_, at_, end_;
  parallel::UnsetVector<std::uint8_t>& still_active_;
};

// Bodies of pairs lie anywhere in memory: fetched some pairs ahead.
constexpr std::size_t kBoundsAhead = 8;
struct Margin {
  double margin_m = 0, skin_m = 0;
};
Margin margin_of(const CoarseInput& input, const BodyBounds& a, const BodyBounds& b) {
  const double dt_s = input.terms.dt_s;
  Margin made;
  made.skin_m = kSkin * (b.plane ? a.radius_m : std::min(a.radius_m, b.radius_m));
  made.margin_m = (a.velocity_mps - b.velocity_mps).norm() * dt_s + a.own_m + b.own_m + made.skin_m;
  // Gravity closes only what it does not pull alike.
  if (!a.dynamic || !b.dynamic) made.margin_m += input.terms.gravity_mps2.norm() * dt_s * dt_s;
  return made;
}

// The bodies of a candidate, a plane second.
struct OrderedPair {
  OrderedPair(const parallel::UnsetVector<BodyBounds>& bounds, const collision::CandidatePair& candidate)
      : a(candidate.low), b(candidate.high) {
    if (bounds[a].plane) std::swap(a, b);
  }
  std::uint32_t a, b;
};

bool may_meet(const CoarseInput& input, const collision::CandidatePair& pair) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const FilteredPair asked{bodies.id_of(pair.low), bodies.id_of(pair.high), bodies.user_data[pair.low],
                           bodies.user_data[pair.high]};
  return input.filter.function(input.filter.context, asked);
}

// Of two bodies without mass for contacts: is one asleep in the way of the other? Others do not meet.
bool meets_sleeper(const dynamics::BodyStore& bodies, const OrderedPair& pair) {
  return (bodies.asleep[pair.a] != 0 && bodies.moves_by_itself(pair.b)) ||
         (bodies.asleep[pair.b] != 0 && bodies.moves_by_itself(pair.a));
}

// What of a cached pair counts now.
void use_cached(const CoarseInput& input, ActivePair& pair, PairStart& start) {
  const double size_m = pair.skin_m / kSkin;
  // Two balls, or a ball and a plane: their only level is exact, and the mandatory part computes it anyway.
  const BodyBounds& a = input.motion.body_bounds[pair.a];
  const BodyBounds& b = input.motion.body_bounds[pair.b];
  const bool exact = a.depth == 0 && b.depth == 0 && !a.meshed && !b.meshed;
  const bool caches = !exact && input.terms.contact != ContactModel::Paper;  // the paper's model answers fronts
  pair.reach_m = caches ? pair.margin_m + kReachOfSize * size_m : pair.margin_m;
  const CachedPair& cached = pair.cached;
  start.cached_level = cached.level;
  if (!caches || cached.reach_m == 0) return;
  if (cached.moved_m + pair.margin_m <= cached.reach_m) {
    start.cached = cached.apart ? CacheUse::Separated : CacheUse::Points;
  } else if (cached.apart && cached.level > 0) {
    if (cached.moved_m <= cached.reach_m + kSinkOfSize * size_m) start.cached = CacheUse::Parted;
  } else if (cached.level > 0 && cached.moved_m <= kHoldOfSize * size_m) {
    start.cached = CacheUse::Expired;
  }
}

// Do the bounds of two bodies meet, as the broad phase asks? Cached candidates may have parted.
bool bounds_meet(const BodyBounds& a, const BodyBounds& b) {
  if (b.plane) return b.position_m.dot(a.position_m) - b.bound_m < a.bound_m;
  const double reach = a.bound_m + b.bound_m;
  return (b.position_m - a.position_m).squaredNorm() < reach * reach;
}

// Are the root spheres of a pair nearer than its margin? World frame, double precision.
bool roots_near(const BodyBounds& a, const BodyBounds& b, double margin_m) {
  if (b.plane) return b.position_m.dot(a.root_center_m) - b.bound_m < a.root_radius_m + margin_m;
  const double reach = a.root_radius_m + b.root_radius_m + margin_m;
  return (b.root_center_m - a.root_center_m).squaredNorm() < reach * reach;
}

// What the forecasts ask of a pair before refinement.
void count_known(const ActivePair& pair, const PairStart& start, bool swept, KnownCount& known) {
  // What backtracking will know of a pair is not known yet.
  const bool apart = start.cached == CacheUse::Separated || start.cached == CacheUse::Parted;
  if (start.refinable() || swept) {
    ++known.refinable;
    known.seen = std::max(known.seen, pair.cached.seen);
  }
  if (pair.cached.slot == kNoSlot && (!apart || start.refinable() || swept)) ++known.without_slot;
  if (apart) return;
  ++known.present;
  if (start.cached != CacheUse::None) return;
  ++known.unknown;
  if (pair.cached.reach_m > 0 && (pair.cached.apart || pair.cached.level > 0)) ++known.outdated;
}

// All that grows with the pairs grows with the capacity of these. Were it reserved when a heap forms, that frame would
// copy all there is and wait for new pages: 10 ms at 2,000 bodies. Reserved beforehand it costs no memory until it is
// used.
void reserve_pairs(PairTable& table, std::size_t bodies) {
  constexpr std::size_t kPairsOfBody = 12;
  constexpr std::size_t kMostPairs = std::size_t{1} << 19U;
  const std::size_t pairs = std::min(kPairsOfBody * bodies, kMostPairs);
  // Again only when the bodies have become twice as many, not a little more for each that comes.
  if (2 * table.pairs.capacity() >= pairs) return;
  parallel::reserve_anew(table.near, pairs);
  parallel::reserve_anew(table.pairs, pairs);
  parallel::reserve_anew(table.start, pairs);
}

// The candidates that are near each other: those of a chunk from where it begins, and how many they are.
void select_near(const CoarseInput& input, PairTable& table, parallel::Executor& executor) {
  const std::span<const collision::CandidatePair> candidates = input.candidates.pairs;
  const parallel::UnsetVector<BodyBounds>& body_bounds = input.motion.body_bounds;
  const SweptBounds& swept = input.motion.swept;
  const std::size_t chunks = (candidates.size() + kCandidateGrain - 1) / kCandidateGrain;
  table.known_of_chunk.assign(chunks + 1, KnownCount{});
  parallel::make_room_anew(table.near, candidates.size());
  table.near.resize(candidates.size());
  parallel::parallel_for(executor, candidates.size(), kCandidateGrain, [&](std::size_t begin, std::size_t end, int) {
    std::uint32_t active = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (i + kBoundsAhead < end) parallel::prefetch(body_bounds[candidates[i + kBoundsAhead].high]);
      const bool fast = swept.fast(candidates[i].low) || swept.fast(candidates[i].high);
      const OrderedPair pair(body_bounds, candidates[i]);
      const BodyBounds& a = body_bounds[pair.a];
      const BodyBounds& b = body_bounds[pair.b];
      if (!fast && !(bounds_meet(a, b) && roots_near(a, b, margin_of(input, a, b).margin_m))) continue;
      if (!a.dynamic && !b.dynamic && !meets_sleeper(input.scene.bodies, pair)) continue;
      if (input.filter.function != nullptr && !may_meet(input, candidates[i])) continue;
      table.near[begin + active++] = static_cast<std::uint32_t>(i);
    }
    table.known_of_chunk[begin / kCandidateGrain + 1].begin = active;
  });
  for (std::size_t chunk = 1; chunk <= chunks; ++chunk)
    table.known_of_chunk[chunk].begin += table.known_of_chunk[chunk - 1].begin;
}

// One chunk of pairs, from its near candidates.
void fill_chunk(const CoarseInput& input, std::size_t chunk, PairTable& table) {
  const std::size_t first = table.begin_of(chunk);
  const std::size_t past = table.end_of(chunk);
  if (first == past) return;
  const parallel::UnsetVector<BodyBounds>& body_bounds = input.motion.body_bounds;
  const SweptBounds& swept = input.motion.swept;
  const std::uint32_t* near = &table.near[chunk * kCandidateGrain];
  const std::span<const collision::CandidatePair> candidates = input.candidates.pairs;
  KnownCount known;
  const collision::CandidatePair& lowest = candidates[*near];
  CachedPairs cached(input.cached, table.still_active, lowest.low, lowest.high);
  for (std::size_t k = first; k < past; ++k) {
    if (k + kBoundsAhead < past) parallel::prefetch(body_bounds[candidates[near[k + kBoundsAhead - first]].high]);
    const OrderedPair bodies(body_bounds, candidates[near[k - first]]);
    const Margin margin = margin_of(input, body_bounds[bodies.a], body_bounds[bodies.b]);
    ActivePair& pair = table.pairs[k];
    pair.a = bodies.a;
    pair.b = bodies.b;
    pair.margin_m = margin.margin_m;
    pair.skin_m = margin.skin_m;
    cached.take(pair.low(), pair.high(), pair.cached);
    // Made in its place: a copy of what has just been written in small parts waits for them.
    PairStart& start = *std::construct_at(&table.start[k]);
    start.seen = pair.cached.seen;
    start.band = pair.cached.band;
    start.waited = static_cast<std::uint8_t>(std::min<std::uint32_t>(pair.cached.frames_waited, 0xff));
    const BodyBounds& a = body_bounds[pair.a];
    const BodyBounds& b = body_bounds[pair.b];
    start.deepest = std::min(input.terms.max_level, std::max(a.depth, b.depth));
    if (input.terms.polygons && (a.meshed || b.meshed)) {
      collision::PairLevel level;
      level.deepest = start.deepest;
      collision::allow_polygons(*input.scene.bodies.shape[pair.a], *input.scene.bodies.shape[pair.b],
                                input.terms.max_level, level);
      start.deepest = level.deepest;
      start.polygons = level.polygons;
      start.next_units = level.next_units;
    }
    use_cached(input, pair, start);
    count_known(pair, start, swept.fast(pair.a) || swept.fast(pair.b), known);
  }
  // Not where it begins: the chunk before reads that.
  KnownCount& counted = table.known_of_chunk[chunk];
  counted.present = known.present;
  counted.unknown = known.unknown;
  counted.outdated = known.outdated;
  counted.refinable = known.refinable;
  counted.without_slot = known.without_slot;
  counted.seen = known.seen;
}

}  // namespace

double coarsest_separation_m(const PredictedMotion& motion, const ActivePair& pair) {
  const BodyBounds& a = motion.body_bounds[pair.a];
  const BodyBounds& b = motion.body_bounds[pair.b];
  if (b.plane) return b.position_m.dot(a.root_center_m) - b.bound_m - a.estimated_radius_m;
  return (b.root_center_m - a.root_center_m).norm() - a.estimated_radius_m - b.estimated_radius_m;
}

bool coarsest_near(const PredictedMotion& motion, const ActivePair& pair) {
  const BodyBounds& a = motion.body_bounds[pair.a];
  const BodyBounds& b = motion.body_bounds[pair.b];
  // What rests on a plane is held by its root sphere too (renew_points.h): few pairs, computed one by one.
  if (b.plane) return true;
  const double reach = a.estimated_radius_m + b.estimated_radius_m + pair.margin_m;
  return reach > 0 && (b.root_center_m - a.root_center_m).squaredNorm() < reach * reach;
}

scheduler::UserData user_data_of(const SceneView& scene, const ActivePair& pair) {
  return {scene.bodies.user_data[pair.low()], scene.bodies.user_data[pair.high()]};
}

double wide_m(const ActivePair& pair) { return kWideOfSize * (pair.skin_m / kSkin); }

void find_active_pairs(const CoarseInput& input, PairTable& table, std::span<collision::FrontPool> pools,
                       parallel::Executor& executor) {
  reserve_pairs(table, input.motion.bounds.size());
  select_near(input, table, executor);
  const std::size_t chunks = table.chunks();
  parallel::make_room_anew(table.pairs, table.known_of_chunk[chunks].begin);
  parallel::resize(executor, table.pairs, table.known_of_chunk[chunks].begin);
  parallel::reserve_anew(table.start, table.pairs.capacity());
  table.start.resize(table.pairs.size());
  parallel::reserve_anew(table.still_active, table.pairs.capacity());
  table.still_active.clear();
  parallel::resize(executor, table.still_active, input.cached.size());
  parallel::parallel_for(executor, chunks, 1,
                         [&](std::size_t chunk, std::size_t, int) { fill_chunk(input, chunk, table); });
  KnownCount& all = table.known_of_chunk[chunks];
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    all.present += table.known_of_chunk[chunk].present;
    all.unknown += table.known_of_chunk[chunk].unknown;
    all.refinable += table.known_of_chunk[chunk].refinable;
  }
  table.swept.clear();
  if (input.motion.swept.on) take_swept_pairs(input, table, pools, executor);
}

}  // namespace poise::simulation
