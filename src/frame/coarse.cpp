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

// Goes through the cached pairs of the last step beside this frame's, both in canonical order, and marks those that it
// meets.
class CachedPairs {
 public:
  CachedPairs(std::span<const CachedPair> cached, parallel::UnsetVector<std::uint8_t>& still_near,
              const collision::CandidatePair& lowest)
      : cached_(cached),
        at_(static_cast<std::size_t>(std::lower_bound(cached.begin(), cached.end(), lowest, before) - cached.begin())),
        still_near_(still_near) {}
  /// Where that of a candidate is, or NearCandidate::kNone.
  std::uint32_t find(const collision::CandidatePair& pair) {
    while (at_ < cached_.size() && before(cached_[at_], pair)) ++at_;
    if (at_ == cached_.size() || cached_[at_].low != pair.low || cached_[at_].high != pair.high)
      return NearCandidate::kNone;
    still_near_[at_] = 1;
    return static_cast<std::uint32_t>(at_);
  }

 private:
  static bool before(const CachedPair& cached, const collision::CandidatePair& pair) {
    return std::pair(cached.low, cached.high) < std::pair(pair.low, pair.high);
  }
  std::span<const CachedPair> cached_;
  std::size_t at_;
  parallel::UnsetVector<std::uint8_t>& still_near_;
};

// Bodies of pairs lie anywhere in memory: fetched some pairs ahead.
constexpr std::size_t kBoundsAhead = 8;
struct Margin {
  double margin_m = 0, skin_m = 0;
};
Margin margin_of(const StepTerms& terms, const BodyBounds& a, const BodyBounds& b) {
  const double dt_s = terms.dt_s;
  Margin made;
  made.skin_m = kSkin * (b.plane ? a.radius_m : std::min(a.radius_m, b.radius_m));
  made.margin_m = (a.velocity_mps - b.velocity_mps).norm() * dt_s + a.own_m + b.own_m + made.skin_m;
  // Gravity closes only what it does not pull alike.
  if (!a.dynamic || !b.dynamic) made.margin_m += terms.gravity_mps2.norm() * dt_s * dt_s;
  return made;
}

// The bodies of a candidate by their places, else by their slots: the plane of a contact point is fixed to the second
// one, and a ball that rolls must not carry it along.
struct OrderedPair {
  OrderedPair(const parallel::UnsetVector<BodyBounds>& bounds, const collision::CandidatePair& candidate)
      : a(candidate.low), b(candidate.high) {
    if (bounds[a].place > bounds[b].place) std::swap(a, b);
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

// May what is found of a pair be cached? Two balls, or a ball and a plane: their only level is exact, and the mandatory
// part computes it anyway. The paper's model answers fronts.
bool caches(const StepTerms& terms, const BodyBounds& a, const BodyBounds& b) {
  const bool exact = a.depth == 0 && b.depth == 0 && !a.meshed && !b.meshed;
  return !exact && terms.contact != ContactModel::Paper;
}

// Is what is cached of a pair still sure?
bool is_sure(const CachedPair& cached, double margin_m) { return cached.moved_m + margin_m <= cached.reach_m; }

// Is it apart (see ActivePair), if what is found of it may be cached? Without a branch: no processor foresees it.
bool is_apart(const CachedPair& cached, double margin_m) {
  const bool known = cached.apart & (cached.reach_m > 0) & is_sure(cached, margin_m);
  const bool ended = !cached.touching & (cached.slot == kNoSlot);
  return known & ended;
}

// Which levels the refinement of a pair has.
void set_levels(const SceneView& scene, const StepTerms& terms, const PredictedMotion& motion, std::uint32_t slot_a,
                std::uint32_t slot_b, PairStart& start) {
  const BodyBounds& a = motion.body_bounds[slot_a];
  const BodyBounds& b = motion.body_bounds[slot_b];
  start.deepest = std::min(terms.max_level, std::max(a.depth, b.depth));
  start.on_ball = a.place == BodyBounds::Place::Ball && b.place == BodyBounds::Place::Between;
  if (!terms.polygons || (!a.meshed && !b.meshed)) return;
  collision::PairLevel level;
  level.deepest = start.deepest;
  collision::allow_polygons(*scene.bodies.shape[slot_a], *scene.bodies.shape[slot_b], terms.max_level, level);
  start.deepest = level.deepest;
  start.polygons = level.polygons;
  start.next_units = level.next_units;
}

// What of a cached pair counts now.
CacheUse use_of_cached(const ActivePair& pair) {
  const CachedPair& cached = *pair.cached;
  if (pair.reach_m == pair.margin_m || cached.reach_m == 0) return CacheUse::None;
  if (is_sure(cached, pair.margin_m)) return cached.apart ? CacheUse::Separated : CacheUse::Points;
  if (cached.level == 0) return CacheUse::None;
  const double size_m = pair.skin_m / kSkin;
  if (cached.apart) return cached.moved_m <= cached.reach_m + kSinkOfSize * size_m ? CacheUse::Parted : CacheUse::None;
  return cached.moved_m <= kHoldOfSize * size_m ? CacheUse::Expired : CacheUse::None;
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
    known.seen = std::max(known.seen, pair.cached->seen);
  }
  if (apart) return;
  ++known.present;
  if (start.cached != CacheUse::None) return;
  ++known.unknown;
  if (pair.cached->reach_m > 0 && (pair.cached->apart || pair.cached->level > 0)) ++known.outdated;
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

// The near pairs of a chunk of candidates.
void select_near_of(const CoarseInput& input, std::size_t chunk, PairTable& table) {
  const std::span<const collision::CandidatePair> candidates = input.candidates.pairs;
  const parallel::UnsetVector<BodyBounds>& body_bounds = input.motion.body_bounds;
  const SweptBounds& swept = input.motion.swept;
  const std::size_t begin = chunk * PairTable::kMostOfChunk;
  const std::size_t end = std::min(begin + PairTable::kMostOfChunk, candidates.size());
  std::size_t active = begin;
  std::size_t apart = begin + PairTable::kMostOfChunk;
  std::uint8_t place = 0;
  CachedPairs cached(input.cached, table.still_near, candidates[begin]);
  for (std::size_t i = begin; i < end; ++i) {
    if (i + kBoundsAhead < end) parallel::prefetch(body_bounds[candidates[i + kBoundsAhead].high]);
    const bool fast = swept.fast(candidates[i].low) || swept.fast(candidates[i].high);
    const OrderedPair pair(body_bounds, candidates[i]);
    const BodyBounds& a = body_bounds[pair.a];
    const BodyBounds& b = body_bounds[pair.b];
    const double margin_m = margin_of(input.terms, a, b).margin_m;
    if (!fast && !(bounds_meet(a, b) && roots_near(a, b, margin_m))) continue;
    if (!a.dynamic && !b.dynamic && !meets_sleeper(input.scene.bodies, pair)) continue;
    if (input.filter.function != nullptr && !may_meet(input, candidates[i])) continue;
    const std::uint32_t at = cached.find(candidates[i]);
    const CachedPair& known = at == NearCandidate::kNone ? kNothingCached : input.cached[at];
    const bool may_be_apart = !fast & !input.all_active & caches(input.terms, a, b);
    const bool goes = may_be_apart & is_apart(known, margin_m);
    apart -= goes ? 1U : 0U;
    table.near[goes ? apart : active] = {at, static_cast<std::uint8_t>(i - begin), place++};
    active += goes ? 0U : 1U;
  }
  KnownCount& known = table.known_of_chunk[chunk + 1];
  known.begin = static_cast<std::uint32_t>(active - begin);
  known.apart_begin = static_cast<std::uint32_t>(begin + PairTable::kMostOfChunk - apart);
}

// The near pairs, and how many of each chunk are active or apart.
void select_near(const CoarseInput& input, PairTable& table, parallel::Executor& executor) {
  const std::size_t chunks = (input.candidates.pairs.size() + PairTable::kMostOfChunk - 1) / PairTable::kMostOfChunk;
  table.known_of_chunk.assign(chunks + 1, KnownCount{});
  parallel::make_room_anew(table.near, chunks * PairTable::kMostOfChunk);
  table.near.resize(chunks * PairTable::kMostOfChunk);
  table.cached = input.cached;
  table.terms = input.terms;
  parallel::reserve_anew(table.still_near, table.pairs.capacity());
  parallel::make_room_anew(table.still_near, input.cached.size());
  table.still_near.clear();
  parallel::resize(executor, table.still_near, input.cached.size());
  parallel::parallel_for(executor, chunks, 1,
                         [&](std::size_t chunk, std::size_t, int) { select_near_of(input, chunk, table); });
  for (std::size_t chunk = 1; chunk <= chunks; ++chunk) {
    table.known_of_chunk[chunk].begin += table.known_of_chunk[chunk - 1].begin;
    table.known_of_chunk[chunk].apart_begin += table.known_of_chunk[chunk - 1].apart_begin;
  }
}

// One chunk of pairs, from its near candidates.
void fill_chunk(const CoarseInput& input, std::size_t chunk, PairTable& table) {
  const std::size_t first = table.begin_of(chunk);
  const std::size_t past = table.end_of(chunk);
  if (first == past) return;
  const parallel::UnsetVector<BodyBounds>& body_bounds = input.motion.body_bounds;
  const SweptBounds& swept = input.motion.swept;
  const NearCandidate* near = &table.near[chunk * PairTable::kMostOfChunk];
  const auto candidate = [&](std::size_t k) {
    return input.candidates.pairs[chunk * PairTable::kMostOfChunk + near[k - first].candidate];
  };
  KnownCount known;
  for (std::size_t k = first; k < past; ++k) {
    if (k + kBoundsAhead < past) {
      parallel::prefetch(body_bounds[candidate(k + kBoundsAhead).high]);
      const std::uint32_t at = near[k + kBoundsAhead - first].cached;
      if (at != NearCandidate::kNone) parallel::prefetch(input.cached[at]);
    }
    const NearCandidate& from = near[k - first];
    const CachedPair& cached = from.cached == NearCandidate::kNone ? kNothingCached : input.cached[from.cached];
    const ActivePair& pair =
        *std::construct_at(&table.pairs[k], near_pair(input.terms, input.motion, candidate(k), cached));
    // Made in its place: a copy of what has just been written in small parts waits for them.
    PairStart& start = *std::construct_at(&table.start[k]);
    start.seen = cached.seen;
    start.band = cached.band;
    start.waited = static_cast<std::uint8_t>(std::min<std::uint32_t>(cached.frames_waited, 0xff));
    set_levels(input.scene, input.terms, input.motion, pair.a, pair.b, start);
    start.cached_level = cached.level;
    start.cached = use_of_cached(pair);
    count_known(pair, start, swept.fast(pair.a) || swept.fast(pair.b), known);
  }
  // Not where it begins: the chunk before reads that.
  KnownCount& counted = table.known_of_chunk[chunk];
  counted.present = known.present;
  counted.unknown = known.unknown;
  counted.outdated = known.outdated;
  counted.refinable = known.refinable;
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

ActivePair near_pair(const StepTerms& terms, const PredictedMotion& motion, const collision::CandidatePair& candidate,
                     const CachedPair& cached) {
  const OrderedPair bodies(motion.body_bounds, candidate);
  const BodyBounds& a = motion.body_bounds[bodies.a];
  const BodyBounds& b = motion.body_bounds[bodies.b];
  const Margin margin = margin_of(terms, a, b);
  const double beyond_m = caches(terms, a, b) ? kReachOfSize * (margin.skin_m / kSkin) : 0.0;
  return {bodies.a, bodies.b, margin.margin_m, margin.skin_m, margin.margin_m + beyond_m, &cached};
}

PairProgress progress_of_apart(const SceneView& scene, const StepTerms& terms, const PredictedMotion& motion,
                               const ActivePair& pair) {
  PairStart start;
  set_levels(scene, terms, motion, pair.a, pair.b, start);
  start.cached = CacheUse::Separated;
  start.cached_level = pair.cached->level;
  start.seen = pair.cached->seen;
  start.band = pair.cached->band;
  return PairProgress(start);
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
