// SPDX-License-Identifier: MIT
#include <hwy/cache_control.h>

#include <algorithm>

#include "collision/triangles/polygon_contact.h"
#include "frame/ccd/swept.h"
#include "frame/host_cues.h"
#include "frame/stages.h"
#include "frame/view_cues.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// Gaps below this share of the smaller body count as touching. Chosen: half a percent is below what a coarse level can
// tell apart, and keeps resting contacts from flickering.
constexpr double kSkin = 5e-3;
// Refinement looks this much of the smaller body beyond what may touch in the step, so that what it finds holds while
// the bodies move so far.
constexpr double kKeep = 6e-3;
// Places that are too old to be sure of are still used until the bodies have moved this much of the smaller one.
// Measured on a frictionless pile whose budget goes off for 60 frames: at a tenth it sinks by a fifth and is thrown up
// again, at a half it stays within 2 % of its height.
constexpr double kHold = 0.5;
// Where no two nodes come within this much of the smaller body more, a pair that was found apart stays so for that much
// longer.
constexpr double kWide = 4 * kKeep;
constexpr std::size_t kCandidateGrain = 128;

double motion_bound_m(const WorldState& world, std::size_t slot, const StepInput& input) {
  const double speed = world.bodies.velocity(slot).norm();
  if (world.bodies.kinematic[slot] != 0) return speed * input.dt_s;
  if (world.bodies.dynamic[slot] == 0) return 0;
  double pull = world.settings.gravity_mps2.norm();
  if (world.bodies.pushed[slot] != 0) pull += world.bodies.force(slot).norm() * world.bodies.inverse_mass[slot];
  return (speed + pull * input.dt_s) * input.dt_s;
}

// Goes through last frame's pairs beside this frame's, both in canonical order, and marks those that it meets.
class Recollection {
 public:
  Recollection(const parallel::LargeVector<CachedPair>& memory, std::vector<std::uint8_t>& recalled, std::uint32_t low,
               std::uint32_t high)
      : begin_(memory.begin()),
        at_(std::lower_bound(memory.begin(), memory.end(), std::pair(low, high), before)),
        end_(memory.end()),
        recalled_(recalled) {}
  CachedPair of(std::uint32_t low, std::uint32_t high) {
    while (at_ != end_ && before(*at_, {low, high})) ++at_;
    if (at_ != end_ && at_->low == low && at_->high == high) {
      recalled_[static_cast<std::size_t>(at_ - begin_)] = 1;
      return *at_;
    }
    CachedPair none;
    none.low = low;
    none.high = high;
    return none;
  }

 private:
  using Key = std::pair<std::uint32_t, std::uint32_t>;
  static bool before(const CachedPair& memory, const Key& key) { return Key(memory.low, memory.high) < key; }
  parallel::LargeVector<CachedPair>::const_iterator begin_, at_, end_;
  std::vector<std::uint8_t>& recalled_;
};

// Bodies of pairs lie anywhere: asked for some pairs ahead.
constexpr std::size_t kAhead = 8;
void fetch(const BodyBounds& make_body_bounds) {
  hwy::Prefetch(&make_body_bounds);
  hwy::Prefetch(&make_body_bounds.velocity_mps);
}

PairRecord make_pair_record(const WorldState& world, const collision::CandidatePair& candidate,
                            const StepInput& input) {
  const parallel::LargeVector<BodyBounds>& body_bounds = world.buffers.body_bounds;
  const bool turned = body_bounds[candidate.low].plane;
  PairRecord pair;
  pair.a = turned ? candidate.high : candidate.low;
  pair.b = turned ? candidate.low : candidate.high;
  const BodyBounds& a = body_bounds[pair.a];
  const BodyBounds& b = body_bounds[pair.b];
  pair.skin_m = kSkin * (b.plane ? a.radius_m : std::min(a.radius_m, b.radius_m));
  pair.margin_m = (a.velocity_mps - b.velocity_mps).norm() * input.dt_s + a.own_m + b.own_m + pair.skin_m;
  // Gravity closes only what it does not pull alike.
  if (!a.dynamic || !b.dynamic) pair.margin_m += world.settings.gravity_mps2.norm() * input.dt_s * input.dt_s;
  return pair;
}

bool may_meet(const WorldState& world, const collision::CandidatePair& pair) {
  const dynamics::BodyStore& bodies = world.bodies;
  const FilteredPair asked{bodies.id_of(pair.low), bodies.id_of(pair.high), bodies.user_data[pair.low],
                           bodies.user_data[pair.high]};
  return world.pair_filter.function(world.pair_filter.context, asked);
}

// Does the body move and have to wake what sleeps in its way? Without sleepers the broad phase need not look.
bool wakes(const dynamics::BodyStore& bodies, std::size_t i) {
  return bodies.asleep_count() > 0 && bodies.moves_by_itself(i);
}

// Of two bodies without mass for contacts: is one asleep in the way of the other? Others do not meet.
bool meets_sleeper(const dynamics::BodyStore& bodies, const PairRecord& pair) {
  return (bodies.asleep[pair.a] != 0 && bodies.moves_by_itself(pair.b)) ||
         (bodies.asleep[pair.b] != 0 && bodies.moves_by_itself(pair.a));
}

BodyBounds make_body_bounds(const WorldState& world, std::size_t i, const StepInput& input) {
  const dynamics::BodyStore& bodies = world.bodies;
  const collision::Pose& pose = world.buffers.poses[i];
  const Shape& shape = *bodies.shape[i];
  BodyBounds made;
  made.dynamic = bodies.dynamic[i] != 0;
  made.meshed = shape.surface != nullptr;
  if (shape.kind == ShapeKind::Plane) {
    made.plane = true;
    made.position_m = pose.rotation * shape.plane_normal;
    made.bound_m = made.position_m.dot(pose.position_m) + shape.plane_offset_m;
    return made;
  }
  made.position_m = pose.position_m;
  made.depth = shape.tree.depth();
  made.radius_m = shape.bounding_radius_m;
  made.bound_m = made.radius_m * (1.0 + kSkin) + motion_bound_m(world, i, input);
  const Sphere root = shape.tree.sphere(0);
  made.root_center_m = pose.position_m + pose.rotation * root.center_m;
  made.root_radius_m = root.radius_m;
  made.estimated_radius_m = made.root_radius_m - collision::coarsest_lift_m(shape);
  made.velocity_mps = bodies.velocity(i);
  // The surface moves by the spin at most across the body.
  made.own_m = std::min(bodies.spin(i).norm() * input.dt_s, 2.0) * made.radius_m;
  if (bodies.pushed[i] != 0) made.own_m += bodies.force(i).norm() * bodies.inverse_mass[i] * input.dt_s * input.dt_s;
  return made;
}

// What of the memory of a pair counts now.
void recall(const WorldState& world, ActivePair& pair) {
  const double size_m = pair.skin_m / kSkin;
  // Two balls, or a ball and a plane: their only level is the truth, and the mandatory part works it out anyway.
  const BodyBounds& a = world.buffers.body_bounds[pair.a];
  const BodyBounds& b = world.buffers.body_bounds[pair.b];
  const bool exact = a.depth == 0 && b.depth == 0 && !a.meshed && !b.meshed;
  const bool keeps = !exact && world.settings.contact != ContactModel::Paper;  // the paper answers fronts
  pair.reach_m = keeps ? pair.margin_m + kKeep * size_m : pair.margin_m;
  pair.cached = CacheUse::None;
  const CachedPair& memory = pair.memory;
  if (!keeps || memory.reach_m == 0) return;
  if (memory.moved_m + pair.margin_m <= memory.reach_m) {
    pair.cached = memory.apart ? CacheUse::Separated : CacheUse::Points;
  } else if (!memory.apart && memory.level > 0 && memory.moved_m <= kHold * size_m) {
    pair.cached = CacheUse::Expired;
  }
}

// Do the bounds of two bodies meet, as the broad phase asks? Candidates that were kept may have parted.
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

// What the viewer sees of a pair that is known by its root spheres alone.
PairView pair_view_of(const WorldState& world, const ActivePair& pair) {
  const BodyBounds& a = world.buffers.body_bounds[pair.a];
  const BodyBounds& b = world.buffers.body_bounds[pair.b];
  PairView pair_view;
  if (b.plane) {
    pair_view.normal = -b.position_m;
    pair_view.point_m = a.root_center_m + a.root_radius_m * pair_view.normal;
  } else {
    const Vec3 between = b.root_center_m - a.root_center_m;
    const double distance = between.norm();
    if (distance > 0) pair_view.normal = between / distance;
    pair_view.point_m = a.root_center_m + 0.5 * between;
  }
  pair_view.extent_m = pair.skin_m / kSkin;
  pair_view.closing_mps = pair_view.normal.dot(a.velocity_mps - b.velocity_mps);
  pair_view.importance = world.bodies.importance[pair.a] * world.bodies.importance[pair.b];
  pair_view.frames_waited = pair.memory.frames_waited;
  return pair_view;
}

// What the pair's score goes by; the host's own cue is asked where there is one.
void fill_cues(const WorldState& world, const ViewQuery& view_query, const ActivePair& pair, scheduler::PairCues& cues,
               KnownCount& known) {
  const scheduler::Policy& policy = world.settings.policy;
  const PairView seen = pair_view_of(world, pair);
  cues = cues_of(view_query, seen, policy);
  if (policy.cue.function == nullptr) return;
  const scheduler::HostFactor host =
      scheduler::host_factor(policy.cue, host_view_of(view_query, seen, pair.id(), user_data_of(world, pair)));
  cues.host = host.factor;
  if (host.refused) ++known.refused_cues;
}

// What the tail and a frame that does not fit ask of a pair before refinement.
void count_known(const ActivePair& pair, bool swept, KnownCount& known) {
  // What backtracking will know of a pair is not known yet.
  if (pair.refinable() || swept) ++known.refinable;
  if (pair.memory.room == kNoSlot && (!pair.apart() || swept)) ++known.without_slot;
  if (pair.apart()) return;
  ++known.present;
  if (pair.cached != CacheUse::None) return;
  ++known.unknown;
  if (pair.memory.reach_m > 0 && (pair.memory.apart || pair.memory.level > 0)) ++known.outdated;
}

}  // namespace

bool coarsest_near(const WorldState& world, const ActivePair& pair) {
  const BodyBounds& a = world.buffers.body_bounds[pair.a];
  const BodyBounds& b = world.buffers.body_bounds[pair.b];
  // What rests on a plane is held by its root sphere too (keep() in kept_places.cpp): few pairs, looked at one by one.
  if (b.plane) return true;
  const double reach = a.estimated_radius_m + b.estimated_radius_m + pair.margin_m;
  return reach > 0 && (b.root_center_m - a.root_center_m).squaredNorm() < reach * reach;
}

scheduler::UserData user_data_of(const WorldState& world, const ActivePair& pair) {
  return {world.bodies.user_data[pair.low()], world.bodies.user_data[pair.high()]};
}

double wide_m(const ActivePair& pair) { return kWide * (pair.skin_m / kSkin); }

collision::PairFrame frame_of(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  collision::PairFrame frame =
      collision::make_pair_frame(*world.bodies.shape[pair.a], buffers.poses[pair.a], *world.bodies.shape[pair.b],
                                 buffers.poses[pair.b], pair.reach_m, pair.skin_m);
  frame.nearness.wide_m = static_cast<float>(wide_m(pair));
  frame.fitted = world.settings.contact == ContactModel::Fitted;
  frame.by_spheres = world.settings.contact == ContactModel::Paper;
  return frame;
}

void predict(WorldState& world, const StepInput& input) {
  const dynamics::BodyStore& bodies = world.bodies;
  FrameBuffers& buffers = world.buffers;
  const std::size_t slots = bodies.slot_count();
  buffers.poses.resize(slots);
  buffers.inverse_inertia.resize(slots);
  buffers.body_bounds.resize(slots);
  buffers.bounds.clear();
  buffers.planes.clear();
  if (input.backtracking || buffers.swept.on) begin_swept(world, input);
  for (std::size_t i = 0; i < slots; ++i) {
    if (bodies.alive[i] == 0) continue;
    if (input.backtracking && sweep_if_fast(world, static_cast<std::uint32_t>(i), input)) continue;
    collision::MotionBound bound;
    bound.slot = static_cast<std::uint32_t>(i);
    if (bodies.shape[i]->kind == ShapeKind::Tree) buffers.bounds.push_back(bound);
  }
  parallel::parallel_for(*world.executor, slots, 4 * kCandidateGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (bodies.alive[i] == 0) continue;
      buffers.poses[i] = {bodies.position(i), bodies.orientation(i).toRotationMatrix()};
      buffers.inverse_inertia[i] = dynamics::inverse_inertia_world(bodies, i);
      buffers.body_bounds[i] = make_body_bounds(world, i, input);
    }
  });
  parallel::parallel_for(*world.executor, buffers.bounds.size(), 4 * kCandidateGrain,
                         [&](std::size_t begin, std::size_t end, int) {
                           for (std::size_t k = begin; k < end; ++k) {
                             collision::MotionBound& bound = buffers.bounds[k];
                             const std::size_t i = bound.slot;
                             bound = {buffers.body_bounds[i].position_m,
                                      buffers.body_bounds[i].bound_m,
                                      bound.slot,
                                      bodies.group[i],
                                      bodies.collides_with[i],
                                      bodies.dynamic[i] != 0 || wakes(bodies, i)};
                           }
                         });
  for (std::size_t i = 0; i < slots; ++i) {
    if (bodies.alive[i] == 0 || bodies.shape[i]->kind != ShapeKind::Plane) continue;
    buffers.planes.push_back({buffers.body_bounds[i].position_m, buffers.body_bounds[i].bound_m,
                              static_cast<std::uint32_t>(i), bodies.group[i], bodies.collides_with[i]});
  }
}

// What a frame keeps of pairs grows with the room of these. Were it made when a heap forms, that frame would copy all
// there is and wait for new pages: 10 ms at 2,000 bodies. Made beforehand it costs no memory until it is used.
void reserve_pairs(FrameBuffers& buffers, std::size_t bodies) {
  constexpr std::size_t kPairsOfBody = 12;
  constexpr std::size_t kMostRoom = std::size_t{1} << 19U;
  const std::size_t room = std::min(kPairsOfBody * bodies, kMostRoom);
  // Again only when the bodies have become twice as many, not a little more for each that comes.
  if (2 * buffers.pairs.capacity() >= room) return;
  buffers.pair_records.reserve(room);
  buffers.pairs.reserve(room);
  buffers.found.reserve(room);
  buffers.cues.reserve(room);
}

void find_pairs(WorldState& world, const StepInput& input, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  const TimePoint start = SteadyClock::now();
  reserve_pairs(buffers, buffers.bounds.size());
  const collision::BroadPhase::Result found =
      world.candidates.find(world.broad_phase, buffers.bounds, buffers.planes,
                            input.backtracking ? std::span<const collision::SweptBound>(buffers.swept.bounds)
                                               : std::span<const collision::SweptBound>{},
                            world.settings.max_partners, *world.executor);
  report.times.broad_phase = SteadyClock::now() - start;
  report.pairs_discarded = found.discarded;
  report.candidate_pairs = found.pairs.size();
  report.work_mandatory = found.pairs.size();

  const auto fast = [&](std::uint32_t slot) { return input.backtracking && buffers.swept.fast(slot); };
  const std::size_t count = found.pairs.size();
  const std::size_t chunks = (count + kCandidateGrain - 1) / kCandidateGrain;
  buffers.known_of_chunk.assign(chunks + 1, KnownCount{});
  buffers.pair_records.resize(count);
  parallel::parallel_for(*world.executor, count, kCandidateGrain, [&](std::size_t begin, std::size_t end, int) {
    std::uint32_t active = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (i + kAhead < end) fetch(buffers.body_bounds[found.pairs[i + kAhead].high]);
      const bool swept = fast(found.pairs[i].low) || fast(found.pairs[i].high);
      PairRecord pair = make_pair_record(world, found.pairs[i], input);
      const BodyBounds& a = buffers.body_bounds[pair.a];
      const BodyBounds& b = buffers.body_bounds[pair.b];
      if (!a.dynamic && !b.dynamic && !meets_sleeper(world.bodies, pair)) continue;
      if (!swept && (!bounds_meet(a, b) || !roots_near(a, b, pair.margin_m))) continue;
      if (world.pair_filter.function != nullptr && !may_meet(world, found.pairs[i])) continue;
      pair.candidate = static_cast<std::uint32_t>(i);
      buffers.pair_records[begin + active++] = pair;
    }
    buffers.known_of_chunk[begin / kCandidateGrain + 1].begin = active;
  });
  for (std::size_t chunk = 1; chunk <= chunks; ++chunk)
    buffers.known_of_chunk[chunk].begin += buffers.known_of_chunk[chunk - 1].begin;
  buffers.pairs.resize(buffers.known_of_chunk[chunks].begin);
  buffers.found.resize(buffers.pairs.size());
  buffers.cues.resize(buffers.pairs.size());
  buffers.recalled.reserve(world.memory.capacity());
  buffers.recalled.assign(world.memory.size(), 0);
  const ViewQuery view_query = input.view;
  parallel::parallel_for(*world.executor, chunks, 1, [&](std::size_t chunk, std::size_t, int) {
    const std::size_t first = buffers.begin_of(chunk);
    const std::size_t past = buffers.end_of(chunk);
    if (first == past) return;
    KnownCount known;
    const collision::CandidatePair& lowest = found.pairs[buffers.pair_records[chunk * kCandidateGrain].candidate];
    Recollection recollection(world.memory, buffers.recalled, lowest.low, lowest.high);
    for (std::size_t k = first; k < past; ++k) {
      if (k + kAhead < past)
        fetch(buffers.body_bounds[buffers.pair_records[chunk * kCandidateGrain + (k + kAhead - first)].b]);
      const PairRecord& near = buffers.pair_records[chunk * kCandidateGrain + (k - first)];
      ActivePair& pair = buffers.pairs[k];
      pair.a = near.a;
      pair.b = near.b;
      pair.margin_m = near.margin_m;
      pair.skin_m = near.skin_m;
      pair.full = pair.exact = pair.solved = false;
      pair.level = {};
      pair.memory = recollection.of(pair.low(), pair.high());
      const BodyBounds& a = buffers.body_bounds[pair.a];
      const BodyBounds& b = buffers.body_bounds[pair.b];
      pair.level.deepest = std::min(input.max_level, std::max(a.depth, b.depth));
      if (input.polygons && (a.meshed || b.meshed)) {
        collision::allow_polygons(*world.bodies.shape[pair.a], *world.bodies.shape[pair.b], input.max_level,
                                  pair.level);
      }
      recall(world, pair);
      count_known(pair, fast(pair.a) || fast(pair.b), known);
      if (pair.refinable()) fill_cues(world, view_query, pair, buffers.cues[k], known);
    }
    // Not where it begins: the chunk before reads that.
    buffers.known_of_chunk[chunk].present = known.present;
    buffers.known_of_chunk[chunk].unknown = known.unknown;
    buffers.known_of_chunk[chunk].outdated = known.outdated;
    buffers.known_of_chunk[chunk].refinable = known.refinable;
    buffers.known_of_chunk[chunk].without_slot = known.without_slot;
    buffers.known_of_chunk[chunk].refused_cues = known.refused_cues;
  });
  KnownCount& all = buffers.known_of_chunk[chunks];
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    all.present += buffers.known_of_chunk[chunk].present;
    all.unknown += buffers.known_of_chunk[chunk].unknown;
    all.refinable += buffers.known_of_chunk[chunk].refinable;
    all.refused_cues += buffers.known_of_chunk[chunk].refused_cues;
  }
  if (input.backtracking) send_swept(world, input, report);
  report.cues_refused = all.refused_cues;
  report.coarse_pairs = buffers.pairs.size();
  report.times.coarse = SteadyClock::now() - start - report.times.broad_phase;
}

}  // namespace poise::simulation
