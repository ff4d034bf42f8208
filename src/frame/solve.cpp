// SPDX-License-Identifier: MIT
#include "frame/solve.h"

#include <algorithm>
#include <memory>
#include <tuple>

#include "parallel/prefetch.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kRowGrain = 256;
// A row that is filled takes half a microsecond.
constexpr std::size_t kFillGrain = 64;

// A worker that fills row after row takes so many places for overlapping points at once. Chosen.
constexpr std::uint32_t kOverlapPlaces = 64;
static_assert(kOverlapPlaces >= 8 * solver::kOverlapsOfRow);
// For those of so many rows: less than one place in eight is left over.
std::size_t most_overlap_places(std::size_t rows, const parallel::Executor& executor) {
  return solver::kOverlapsOfRow * rows * 8 / 7 + static_cast<std::size_t>(executor.concurrency()) * kOverlapPlaces;
}

SolvedPair solved_pair(const SolveInput& input, const PointCache& points) {
  return {input.scene, input.motion, input.table, input.levels, input.manifolds, points, input.terms.contact};
}

solver::LaneMemory& memory_of(const SolveInput& input, Velocities& velocities) {
  return input.memory != nullptr ? *input.memory : velocities.lane_memory;
}

// Has the pair one contact that is exact, in place of those of spheres? That of polygons, or of a fast body.
bool solves_one_contact(const PairProgress& progress) { return progress.by_polygons() || progress.exact; }

// Memory for the sphere contacts of each pair that the paper's model solves.
void reserve_sphere_points(const SolveInput& input, Velocities& velocities) {
  if (input.terms.contact != ContactModel::Paper) return;
  std::uint32_t points = 0;
  velocities.points_begin.reserve(input.table.capacity());
  velocities.points_begin.clear();
  for (const solver::Manifold& manifold : input.manifolds.manifolds) {
    const PairProgress& pair = input.levels.progress[manifold.pair];
    velocities.points_begin.push_back(points);
    if (!solves_one_contact(pair)) points += pair.level.front_entries;
  }
  velocities.points.resize(points);
}

void fill_bodies(const SolveInput& input, Velocities& velocities, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  parallel::resize(executor, velocities.bodies, bodies.slot_count());
  const bool everything = std::exchange(velocities.everything, false);
  const std::vector<std::uint32_t>& visited = input.motion.visited;
  const std::size_t count = everything ? bodies.slot_count() : visited.size();
  const solver::SolverBody still;
  // Most bodies have one of the first two.
  constexpr std::uint32_t kGravity = 1;
  parallel::grow_anew(velocities.accelerations, kGravity + 1 + count);
  velocities.accelerations[0] = {};
  velocities.accelerations[kGravity] = {input.terms.gravity_mps2, Vec3::Zero()};
  parallel::Tickets pushed;
  parallel::parallel_for(executor, count, kRowGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = everything ? k : visited[k];
      solver::SolverBody& body = velocities.bodies[i];
      body = still;
      if (bodies.dynamic[i] == 0 && bodies.kinematic[i] == 0) continue;
      body.held = input.levels.held.holds(i);
      if (body.held) continue;
      body.velocity_mps = bodies.velocity(i);
      body.spin_radps = bodies.spin(i);
      if (bodies.dynamic[i] == 0) continue;
      body.inverse_mass = bodies.inverse_mass[i];
      body.acceleration = kGravity;
      if (bodies.pushed[i] == 0) continue;
      body.acceleration = static_cast<std::uint32_t>(kGravity + 1 + pushed.take());
      solver::Acceleration& acceleration = velocities.accelerations[body.acceleration];
      acceleration.linear_mps2 = input.terms.gravity_mps2;
      acceleration.linear_mps2 += bodies.inverse_mass[i] * bodies.force(i);
      acceleration.angular_radps2 = input.motion.inverse_inertia[i] * bodies.torque(i);
    }
  });
}

// Fills the rows of impacts.
class PairRows final : public solver::RowSource {
 public:
  // What the rows of a step are counted in.
  struct Counts {
    parallel::Tickets degenerate;
    parallel::Tickets overlaps;  // places for overlapping points that have been given away
  };
  PairRows(const SolveInput& input, const PointCache& points, Velocities& velocities, Counts& counts)
      : input_(input), points_(points), velocities_(velocities), counts_(counts) {}
  // Prefetches what fill() reads and writes of a manifold.
  HWY_INLINE void prefetch(std::size_t m) const {
    const solver::Manifold& manifold = input_.manifolds.manifolds[m];
    if (!manifold.fast || manifold.point_count == 0) return;
    // Where there is more than one, the point of the impact lies before them.
    const std::size_t first = manifold.point_begin - PointCache::before_manifold(manifold.point_count + 1U);
    for (std::size_t p = first; p < manifold.point_begin + std::size_t{manifold.point_count}; ++p)
      parallel::prefetch(points_.points[p]);
    for (const std::uint32_t body : {manifold.a, manifold.b}) {
      parallel::prefetch(input_.motion.poses[body]);
      parallel::prefetch(input_.motion.inverse_inertia[body]);
    }
    parallel::prefetch(input_.table.pairs[manifold.pair]);
    parallel::prefetch(input_.manifolds.points[manifold.pair]);
    parallel::prefetch(input_.levels.progress[manifold.pair]);
    parallel::prefetch(input_.levels.found.of(input_.levels.progress[manifold.pair]).contact);
    parallel::prefetch(velocities_.rows[input_.manifolds.coloring.places()[m]]);
  }
  void fill(std::size_t k) const override {
    OverlapRoom room;  // of this row alone
    fill(k, room);
  }
  void fill(std::size_t k, OverlapRoom& room) const {
    const std::uint32_t index = input_.manifolds.coloring.order()[k];
    const solver::Manifold& manifold = input_.manifolds.manifolds[index];
    const ActivePair& pair = input_.table.pairs[manifold.pair];
    const PairProgress& progress = input_.levels.progress[manifold.pair];
    const PairPoints& points = input_.manifolds.points[manifold.pair];
    const solver::PlacedPoint single = impact_point_of(input_.motion, points_, pair, points.slot);
    // Made in its place: a copy of what has just been written in small parts waits for them.
    solver::ContactRow& row = *std::construct_at(&velocities_.rows[k]);
    row.a = manifold.a;
    row.b = manifold.b;
    row.gap_m = single.gap_m;
    row.restitution = manifold.restitution;
    row.friction = manifold.friction;
    row.a_to_b_m = input_.motion.poses[pair.b].position_m - input_.motion.poses[pair.a].position_m;
    if (points.point_count > 1 && row.restitution > 0 && may_overlap(pair, progress, points))
      list_overlaps(pair, manifold, k, room, row);
    if (progress.from_cache()) {
      row.arm_m = single.arm_m;
      row.wrench = {single.normal, row.arm_m.cross(single.normal), (row.arm_m - row.a_to_b_m).cross(single.normal)};
      move_to_surface(pair, 0.5, single.gap_m, row);
    } else {
      collision::PairContact coarsest;
      const collision::PairContact& contact =
          contact_of(input_.scene, input_.motion, pair, progress, input_.levels.found.of(progress), coarsest);
      row.arm_m = contact.arm_m;
      row.wrench = {contact.direction, contact.moment_a_m, contact.moment_b_m};
      const std::optional<double> share = share_of_contact(input_.motion, pair, progress);
      const double gap_m = progress.level.level > 0 ? contact.estimated_separation_m : contact.spheres_m;
      if (share) move_to_surface(pair, *share, gap_m, row);
    }
    const auto& inverse_mass = input_.scene.bodies.inverse_mass;
    const auto& inverse_inertia = input_.motion.inverse_inertia;
    if (!solver::prepare_wrench(inverse_mass[pair.a], inverse_inertia[pair.a], inverse_mass[pair.b],
                                inverse_inertia[pair.b], row.wrench, row.turns)) {
      counts_.degenerate.take(1);
    }
    if (input_.terms.contact == ContactModel::Paper) {
      row.gap_m = solved_gap_m(solved_pair(input_, points_), manifold.pair);
      fill_points(pair, progress, index, row);
    }
  }

 private:
  // Where the impulse acts by share_of_gap, for a contact point that is at `share` of the gap.
  void move_to_surface(const ActivePair& pair, double share, double gap_m, solver::ContactRow& row) const {
    const auto& inverse_mass = input_.scene.bodies.inverse_mass;
    const double wanted = solver::share_of_gap(inverse_mass[pair.a], inverse_mass[pair.b]);
    // Moments about the normal are the same anywhere along it.
    if (wanted == 0 || wanted == 1) row.arm_m += ((wanted - share) * gap_m) * row.wrench.direction.normalized();
  }

  // May a point of the pair penetrate, by the separations that *manifolds* knows and how far they can have changed?
  static bool may_overlap(const ActivePair& pair, const PairProgress& progress, const PairPoints& points) {
    constexpr double kRoundingOfSkin = 1e-6;
    const double changed_m = progress.from_cache() ? 2.0 * (pair.cached->moved_m - points.looked_m) : 0.0;
    return points.nearest_m <= changed_m + kRoundingOfSkin * pair.skin_m;
  }

  // The points of the manifold that certainly penetrate.
  void list_overlaps(const ActivePair& pair, const solver::Manifold& manifold, std::size_t k, OverlapRoom& room,
                     solver::ContactRow& row) const {
    const collision::Pose& a = input_.motion.poses[pair.a];
    const collision::Pose& b = input_.motion.poses[pair.b];
    if (room.past - room.next < manifold.point_count) {
      const std::uint32_t taken = std::max<std::uint32_t>(room.at_once, manifold.point_count);
      room.next = static_cast<std::uint32_t>(counts_.overlaps.take(taken));
      room.past = room.next + taken;
    }
    const std::uint32_t first = room.next;
    for (std::uint32_t p = manifold.point_begin; p < manifold.point_begin + manifold.point_count; ++p) {
      const solver::PlacedPoint point = solver::placed_point(a, b, points_.points[p]);
      if (point.certain_separation_m > 0) continue;
      velocities_.overlaps[room.next++] = {point.normal, point.arm_m.cross(point.normal),
                                           (point.arm_m - row.a_to_b_m).cross(point.normal), row.restitution};
      row.overlap_reach_m = std::max(row.overlap_reach_m, point.arm_m.norm());
    }
    solver::RowActivation& gate = velocities_.scratch.activations[k];
    gate.overlaps_begin = first;
    gate.overlap_count = static_cast<std::uint8_t>(room.next - first);
  }

  // Sphere contacts of the paper's model, from the front of the pair.
  void fill_points(const ActivePair& pair, const PairProgress& progress, std::uint32_t index,
                   solver::ContactRow& row) const {
    row.points_begin = row.points_end = velocities_.points_begin[index];
    if (solves_one_contact(progress)) return;  // the row itself
    const PairRefiner refiner{input_.scene, input_.terms.contact};
    const collision::PairFrame frame = frame_of(refiner, posed(input_.motion, pair));
    const Mat3& turn = input_.motion.poses[pair.a].rotation;
    collision::for_each_segment(
        input_.pools, progress.level.front, [&](std::span<const collision::FrontEntry> entries) {
          for (const collision::FrontEntry entry : entries) {
            const collision::SphereContact contact = collision::sphere_contact(frame, entry);
            velocities_.points[row.points_end++] = {turn * contact.normal, turn * contact.point_m,
                                                    turn * (contact.point_m - frame.offset_m), contact.gap_m};
          }
        });
  }

  const SolveInput& input_;
  const PointCache& points_;
  Velocities& velocities_;
  Counts& counts_;
};

// An activation for each row, none of the rows filled.
void deactivate_rows(const SolveInput& input, Velocities& velocities, parallel::Executor& executor) {
  const Manifolds& manifolds = input.manifolds;
  const std::size_t count = manifolds.manifolds.size();
  std::tie(velocities.rows, velocities.overlaps) =
      memory_of(input, velocities)
          .use_anew<solver::ContactRow, solver::OverlapPoint>(count, most_overlap_places(count, executor));
  velocities.scratch.activations.resize(count);
  const std::span<const std::uint32_t> places = manifolds.coloring.places();
  parallel::parallel_for(executor, places.size(), kRowGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t m = begin; m < end; ++m) {
      const solver::Manifold& manifold = manifolds.manifolds[m];
      solver::RowActivation& gate = velocities.scratch.activations[places[m]];
      gate = {manifold.a, manifold.b};
      gate.fast = manifold.fast;
      gate.ready = false;
    }
  });
}

// Fills the rows that the first round looks at. In the order of the pairs, in which all that a row is made of lies side
// by side; in the order of the rows nearly every read would wait for memory.
void fill_fast_rows(const Manifolds& manifolds, const PairRows& source, Velocities& velocities,
                    parallel::Executor& executor) {
  constexpr std::size_t kAhead = 4;
  const bool distant = manifolds.manifolds.size() > parallel::kPairsAtHand;
  velocities.overlap_rooms.assign(static_cast<std::size_t>(executor.concurrency()), {0, 0, kOverlapPlaces});
  parallel::parallel_for(executor, manifolds.manifolds.size(), kFillGrain,
                         [&](std::size_t begin, std::size_t end, int worker) {
                           OverlapRoom& room = velocities.overlap_rooms[static_cast<std::size_t>(worker)];
                           for (std::size_t m = begin; m < end; ++m) {
                             if (distant && m + kAhead < end) source.prefetch(m + kAhead);
                             if (!manifolds.manifolds[m].fast) continue;
                             const std::uint32_t row = manifolds.coloring.places()[m];
                             source.fill(row, room);
                             solver::activate(velocities.rows[row], velocities.scratch.activations[row]);
                           }
                         });
}

// What the rows received; these are gone when the contact points take their memory.
void keep_impacts(const Manifolds& manifolds, Velocities& velocities, parallel::Executor& executor) {
  constexpr std::size_t kAhead = 8;
  const std::span<const std::uint32_t> places = manifolds.coloring.places();
  const bool distant = places.size() > parallel::kPairsAtHand;
  velocities.impact_ns.resize(places.size());
  parallel::parallel_for(executor, places.size(), kRowGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t m = begin; m < end; ++m) {
      if (distant && m + kAhead < end && velocities.scratch.activations[places[m + kAhead]].ready)
        parallel::prefetch(velocities.rows[places[m + kAhead]]);
      const std::uint32_t k = places[m];
      velocities.impact_ns[m] = velocities.scratch.activations[k].ready ? velocities.rows[k].impact_ns() : Vec3::Zero();
    }
  });
}

// What closes fast enough to rebound is the business of impacts: the contact solver leaves it out.
void leave_bouncing(const Manifolds& all, Velocities& velocities, parallel::Executor& executor) {
  velocities.point_count = all.manifold_points;
  velocities.bounced = false;
  if (!all.impacts) return;
  const std::size_t count = all.manifolds.size();
  const auto bounces = [&](std::size_t row) { return velocities.scratch.activations[row].bounces; };
  parallel::Tickets rows;
  parallel::Tickets points;
  const std::span<const std::uint32_t> order = all.coloring.order();
  parallel::for_ranges(executor, {count, kRowGrain}, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::size_t bouncing = 0;
    std::size_t their_points = 0;
    for (std::size_t k = begin; k < end; ++k) {
      if (!bounces(k)) continue;
      ++bouncing;
      their_points += all.manifolds[order[k]].point_count;
    }
    rows.take(bouncing);
    points.take(their_points);
  });
  velocities.bounced = rows.take(0) > 0;
  velocities.point_count -= points.take(0);
  if (!velocities.bounced) return;
  velocities.left_out.resize(count);
  parallel::for_ranges(executor, {count, kRowGrain}, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t m = begin; m < end; ++m) velocities.left_out[m] = bounces(all.coloring.places()[m]) ? 1 : 0;
  });
}

}  // namespace

solver::PlacedPoint impact_point_of(const PredictedMotion& motion, const PointCache& points, const ActivePair& pair,
                                    std::uint32_t slot) {
  return solver::placed_point(motion.poses[pair.a], motion.poses[pair.b], points.points[PointCache::begin(slot)]);
}

double solved_gap_m(const SolvedPair& solved, std::uint32_t pair) {
  const ActivePair& active = solved.table.pairs[pair];
  const PairProgress& progress = solved.levels.progress[pair];
  // The paper's model solves the spheres themselves; the others solve the surfaces that are likely inside them.
  if (solved.contact == ContactModel::Paper && !progress.from_cache()) {
    collision::PairContact coarsest;
    return contact_of(solved.scene, solved.motion, active, progress, solved.levels.found.of(progress), coarsest)
        .spheres_m;
  }
  return impact_point_of(solved.motion, solved.points, active, solved.manifolds.points[pair].slot).gap_m;
}

solver::System impact_system(const SolveInput& input, Velocities& velocities) {
  return {
      velocities.bodies,        velocities.rows,   velocities.points, velocities.overlaps, input.motion.inverse_inertia,
      input.manifolds.coloring, velocities.scratch};
}

void fill_rows(const SolveInput& input, const PointCache& points, Velocities& velocities,
               parallel::Executor& executor) {
  PairRows::Counts counts;
  const PairRows source(input, points, velocities, counts);
  deactivate_rows(input, velocities, executor);
  for (std::size_t k = 0; k < input.manifolds.manifolds.size(); ++k) source.fill(k);
}

void begin_solve(const SolveInput& input, Velocities& velocities, parallel::Executor& executor) {
  // All grow with the pairs, so that later frames that solve a larger share of them need no new memory.
  const std::size_t most = input.table.capacity();
  velocities.applied_impulse_ns.reserve(most);
  parallel::reserve_anew(velocities.impact_ns, most);
  memory_of(input, velocities)
      .reserve<solver::ContactRow, solver::OverlapPoint>(most, most_overlap_places(most, executor));
  velocities.scratch.activations.reserve(most);
  parallel::reserve_anew(velocities.left_out, most);
  velocities.applied_impulse_ns.resize(input.manifolds.manifolds.size());
  velocities.swept.trajectories.clear();
  velocities.swept.hits.clear();
  reserve_sphere_points(input, velocities);
  fill_bodies(input, velocities, executor);
}

solver::Convergence solve_impacts(const SolveInput& input, const PointCache& points, Velocities& velocities,
                                  FrameReport& report, parallel::Executor& executor) {
  velocities.impact_ns.clear();
  if (!input.manifolds.impacts) {
    leave_bouncing(input.manifolds, velocities, executor);
    return {};
  }
  PairRows::Counts counts;
  const PairRows source(input, points, velocities, counts);
  deactivate_rows(input, velocities, executor);
  fill_fast_rows(input.manifolds, source, velocities, executor);
  solver::System system = impact_system(input, velocities);
  system.source = &source;
  const solver::Convergence ended = solver::solve_impacts(system, input.settings(), executor);
  report.degenerate = counts.degenerate.take(0);
  keep_impacts(input.manifolds, velocities, executor);
  leave_bouncing(input.manifolds, velocities, executor);
  return ended;
}

solver::ContactSystem contact_system(const SolveInput& input, PointCache& points, Velocities& velocities) {
  return {velocities.bodies,
          velocities.accelerations,
          input.motion.inverse_inertia,
          input.motion.poses,
          input.manifolds.manifolds,
          points.points,
          points.forces,
          velocities.applied_impulse_ns,
          input.manifolds.coloring,
          velocities.point_count,
          input.motion.visited,
          true,
          velocities.bounced ? std::span<const std::uint8_t>(velocities.left_out) : std::span<const std::uint8_t>(),
          &memory_of(input, velocities)};
}

solver::Convergence solve_contacts(const SolveInput& input, const IterationsAllowed& allowed, PointCache& points,
                                   solver::ContactSolver& contact_solver, Velocities& velocities,
                                   parallel::Executor& executor) {
  solver::SolveSettings settings = input.settings();
  settings.collide = input.manifolds.impacts;
  settings.point_iterations = allowed.most;
  settings.until = allowed.until;
  settings.repeated = allowed.repeated;
  return contact_solver.solve(contact_system(input, points, velocities), settings, executor);
}

}  // namespace poise::simulation
