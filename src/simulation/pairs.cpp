// SPDX-License-Identifier: MIT
#include <algorithm>
#include <numeric>

#include "collision/polygon_contact.h"
#include "parallel/shared.h"
#include "simulation/cues.h"
#include "simulation/stages.h"
#include "simulation/swept.h"

namespace poise::simulation {
namespace {

// Gaps below this share of the smaller body count as touching. Chosen: half a percent is below what a coarse level can
// tell apart, and keeps resting contacts from flickering.
constexpr double kSkin = 5e-3;
// Refinement looks this much of the smaller body beyond what may touch in the step, so that what it finds holds while the bodies move so far.
constexpr double kKeep = 6e-3;
// Places that are too old to be sure of are still used until the bodies have moved this much of the smaller one: about the radius of a leaf.
constexpr double kHold = 0.1;
constexpr std::size_t kGrain = 128;

double motion_bound_m(const WorldState& world, std::size_t slot, const StepInput& input) {
  if (world.bodies.dynamic[slot] == 0) return 0;
  const double speed = world.bodies.velocity(slot).norm();
  double pull = world.settings.gravity_mps2.norm();
  if (world.bodies.pushed[slot] != 0) pull += world.bodies.force(slot).norm() * world.bodies.inverse_mass[slot];
  return (speed + pull * input.dt_s) * input.dt_s;
}

// How much the gap of two bodies may close in the step, by their own motion.
double margin_m(const WorldState& world, std::size_t a, std::size_t b, double skin_m, const StepInput& input) {
  const dynamics::BodyStore& bodies = world.bodies;
  const double h = input.dt_s;
  double closing = (bodies.velocity(a) - bodies.velocity(b)).norm() * h;
  for (const std::size_t i : {a, b}) {
    // The surface moves by the spin at most across the body.
    const double radius = bodies.shape[i]->bounding_radius_m;
    closing += std::min(bodies.spin(i).norm() * h, 2.0) * radius;
    if (bodies.pushed[i] != 0) closing += bodies.force(i).norm() * bodies.inverse_mass[i] * h * h;
  }
  // Gravity closes only what it does not pull alike.
  if (bodies.dynamic[a] == 0 || bodies.dynamic[b] == 0) closing += world.settings.gravity_mps2.norm() * h * h;
  return closing + skin_m;
}

// Goes through last frame's pairs beside this frame's, both in canonical order.
class Recollection {
 public:
  Recollection(const std::vector<PairMemory>& memory, std::uint32_t low, std::uint32_t high)
      : at_(std::lower_bound(memory.begin(), memory.end(), std::pair(low, high), before)), end_(memory.end()) {}
  PairMemory of(std::uint32_t low, std::uint32_t high) {
    while (at_ != end_ && before(*at_, {low, high})) ++at_;
    if (at_ != end_ && at_->low == low && at_->high == high) return *at_;
    PairMemory none;
    none.low = low;
    none.high = high;
    return none;
  }

 private:
  using Key = std::pair<std::uint32_t, std::uint32_t>;
  static bool before(const PairMemory& memory, const Key& key) { return Key(memory.low, memory.high) < key; }
  std::vector<PairMemory>::const_iterator at_, end_;
};

// Slots and margins of a candidate; nothing that needs its shapes refined.
ActivePair outlined(const WorldState& world, const collision::CandidatePair& candidate, const StepInput& input) {
  const auto is_plane = [&](std::uint32_t slot) { return world.bodies.shape[slot]->kind == ShapeKind::Plane; };
  ActivePair pair;
  pair.low = candidate.low;
  pair.high = candidate.high;
  pair.a = is_plane(candidate.low) ? candidate.high : candidate.low;
  pair.b = is_plane(candidate.low) ? candidate.low : candidate.high;
  const double radius_a = world.bodies.shape[pair.a]->bounding_radius_m;
  const double radius_b = is_plane(pair.b) ? radius_a : world.bodies.shape[pair.b]->bounding_radius_m;
  pair.skin_m = kSkin * std::min(radius_a, radius_b);
  pair.margin_m = margin_m(world, pair.a, pair.b, pair.skin_m, input);
  return pair;
}

// What of the memory of a pair counts now.
void recall(const WorldState& world, ActivePair& pair) {
  const double size_m = pair.skin_m / kSkin;
  const bool exact = pair.level.deepest == 0;  // its only level is the truth, and the mandatory part works it out anyway
  const bool keeps = !exact && world.settings.contact != ContactModel::Paper;  // the paper answers fronts
  pair.reach_m = keeps ? pair.margin_m + kKeep * size_m : pair.margin_m;
  pair.kept = Kept::Nothing;
  const PairMemory& memory = pair.memory;
  if (!keeps || memory.reach_m == 0) return;
  if (memory.moved_m + pair.margin_m <= memory.reach_m) {
    pair.kept = memory.apart ? Kept::Apart : Kept::Places;
  } else if (!memory.apart && memory.moved_m <= kHold * size_m) {
    pair.kept = Kept::Stale;
  }
}

// Are the root spheres of a pair nearer than its margin? World frame, double precision.
bool roots_near(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  const double radius_a = static_cast<double>(world.bodies.shape[pair.a]->tree.radius_m[0]);
  const Vec3& center_a = buffers.root_center_m[pair.a];
  const Shape& shape_b = *world.bodies.shape[pair.b];
  if (shape_b.kind == ShapeKind::Plane) {
    const Vec3 normal = buffers.poses[pair.b].rotation * shape_b.plane_normal;
    const double height = normal.dot(center_a - buffers.poses[pair.b].position_m) - shape_b.plane_offset_m;
    return height < radius_a + pair.margin_m;
  }
  const double reach = radius_a + static_cast<double>(shape_b.tree.radius_m[0]) + pair.margin_m;
  return (buffers.root_center_m[pair.b] - center_a).squaredNorm() < reach * reach;
}

// What the viewer sees of a pair that is known by its root spheres alone.
PairSighting sighting_of(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  const dynamics::BodyStore& bodies = world.bodies;
  const Shape& shape_b = *bodies.shape[pair.b];
  PairSighting sighting;
  const Vec3& center_a = buffers.root_center_m[pair.a];
  if (shape_b.kind == ShapeKind::Plane) {
    sighting.normal = -(buffers.poses[pair.b].rotation * shape_b.plane_normal);
    sighting.point_m = center_a + static_cast<double>(bodies.shape[pair.a]->tree.radius_m[0]) * sighting.normal;
  } else {
    const Vec3 between = buffers.root_center_m[pair.b] - center_a;
    const double distance = between.norm();
    if (distance > 0) sighting.normal = between / distance;
    sighting.point_m = center_a + 0.5 * between;
  }
  sighting.extent_m = pair.skin_m / kSkin;
  sighting.closing_mps = sighting.normal.dot(bodies.velocity(pair.a) - bodies.velocity(pair.b));
  sighting.importance = bodies.importance[pair.a] * bodies.importance[pair.b];
  sighting.frames_waited = pair.memory.frames_waited;
  return sighting;
}

}  // namespace

collision::PairFrame frame_of(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  collision::PairFrame frame =
      collision::make_pair_frame(*world.bodies.shape[pair.a], buffers.poses[pair.a], *world.bodies.shape[pair.b],
                                 buffers.poses[pair.b], pair.reach_m, pair.skin_m);
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
  buffers.root_center_m.resize(slots);
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
  parallel::parallel_for(*world.executor, slots, 4 * kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (bodies.alive[i] == 0) continue;
      buffers.poses[i] = {bodies.position(i), bodies.orientation(i).toRotationMatrix()};
      buffers.inverse_inertia[i] = dynamics::inverse_inertia_world(bodies, i);
      if (bodies.shape[i]->kind == ShapeKind::Plane) continue;
      buffers.root_center_m[i] =
          buffers.poses[i].position_m + buffers.poses[i].rotation * bodies.shape[i]->tree.sphere(0).center_m;
    }
  });
  parallel::parallel_for(*world.executor, buffers.bounds.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      collision::MotionBound& bound = buffers.bounds[k];
      const std::size_t i = bound.slot;
      const double radius = bodies.shape[i]->bounding_radius_m;
      bound = {bodies.position(i), radius * (1.0 + kSkin) + motion_bound_m(world, i, input), bound.slot,
               bodies.group[i],    bodies.collides_with[i],                                  bodies.dynamic[i] != 0};
    }
  });
  for (std::size_t i = 0; i < slots; ++i) {
    if (bodies.alive[i] == 0 || bodies.shape[i]->kind != ShapeKind::Plane) continue;
    const Vec3 normal = buffers.poses[i].rotation * bodies.shape[i]->plane_normal;
    buffers.planes.push_back({normal, normal.dot(bodies.position(i)) + bodies.shape[i]->plane_offset_m,
                              static_cast<std::uint32_t>(i), bodies.group[i], bodies.collides_with[i]});
  }
}

void find_pairs(WorldState& world, const StepInput& input, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  const TimePoint start = SteadyClock::now();
  const collision::BroadPhase::Result found =
      world.broad_phase.find(buffers.bounds, buffers.planes, world.settings.max_partners, *world.executor,
                             input.backtracking ? std::span<const collision::SweptBound>(buffers.swept.bounds) : std::span<const collision::SweptBound>{});
  report.times.broad_phase = SteadyClock::now() - start;
  report.pairs_dropped = found.dropped;
  report.candidate_pairs = found.pairs.size();
  report.work_mandatory = found.pairs.size();

  const std::size_t count = found.pairs.size();
  const std::size_t chunks = (count + kGrain - 1) / kGrain;
  buffers.active_of_chunk.assign(chunks + 1, 0);
  buffers.active_candidate.resize(count);
  parallel::parallel_for(*world.executor, count, kGrain, [&](std::size_t begin, std::size_t end, int) {
    std::uint32_t active = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const bool swept = input.backtracking && (buffers.swept.fast(found.pairs[i].low) || buffers.swept.fast(found.pairs[i].high));
      if (!swept && !roots_near(world, outlined(world, found.pairs[i], input))) continue;
      buffers.active_candidate[begin + active++] = static_cast<std::uint32_t>(i);
    }
    buffers.active_of_chunk[begin / kGrain + 1] = active;
  });
  std::partial_sum(buffers.active_of_chunk.begin(), buffers.active_of_chunk.end(), buffers.active_of_chunk.begin());
  buffers.pairs.resize(buffers.active_of_chunk[chunks]);
  parallel::parallel_for(*world.executor, chunks, 1, [&](std::size_t chunk, std::size_t, int) {
    const std::uint32_t first = buffers.active_of_chunk[chunk];
    if (first == buffers.active_of_chunk[chunk + 1]) return;
    const collision::CandidatePair& lowest = found.pairs[buffers.active_candidate[chunk * kGrain]];
    Recollection recollection(world.memory, lowest.low, lowest.high);
    for (std::uint32_t k = first; k < buffers.active_of_chunk[chunk + 1]; ++k) {
      const std::uint32_t candidate = buffers.active_candidate[chunk * kGrain + (k - first)];
      ActivePair& pair = buffers.pairs[k];
      pair = outlined(world, found.pairs[candidate], input);
      pair.memory = recollection.of(pair.low, pair.high);
      const Shape& shape_a = *world.bodies.shape[pair.a];
      const Shape& shape_b = *world.bodies.shape[pair.b];
      pair.level.deepest = collision::deepest_level(shape_a, shape_b, input.max_level);
      if (input.polygons) collision::allow_polygons(shape_a, shape_b, input.max_level, pair.level);
      recall(world, pair);
      if (pair.refinable()) pair.cues = cues_of(input.view, sighting_of(world, pair));
    }
  });
  if (input.backtracking) send_swept(world, input, report);
  report.coarse_pairs = buffers.pairs.size();
  report.times.coarse = SteadyClock::now() - start - report.times.broad_phase;
}

}  // namespace poise::simulation
