// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "frame/ccd/swept.h"
#include "frame/ccd/swept_contact.h"
#include "frame/kinematic.h"
#include "parallel/shared_counters.h"
#include "solver/impacts/impact_row.h"
#include "solver/solver.h"

namespace poise::simulation {
namespace {

using collision::MovingBody;
using collision::TimeOfImpact;

constexpr std::size_t kTrajectoryGrain = 256;

// How far the solver is about to move a body.
Vec3 planned_motion_m(const Velocities& velocities, std::size_t i, double h_s) {
  const solver::SolverBody& solved = velocities.bodies[i];
  if (solved.solved) return solved.moved_m;
  return h_s * solved.velocity_mps - (0.5 * h_s * h_s) * velocities.acceleration_of(i).linear_mps2;
}

// Its velocity on the way: forces act all along it, unless contacts hold it. What has a contact that does not hold it
// must not gain, where it is stopped, what forces would have given it on the rest of its way.
Vec3 velocity_at_mps(const Velocities& velocities, std::size_t i, double time_s, double h_s) {
  const solver::SolverBody& solved = velocities.bodies[i];
  const Vec3 before_mps = solved.velocity_mps - (h_s - time_s) * velocities.acceleration_of(i).linear_mps2;
  const bool held = solved.solved && before_mps.squaredNorm() >= solved.velocity_mps.squaredNorm();
  return held ? solved.velocity_mps : before_mps;
}

// When a body has to stop so that it does not leave what was swept for it: a slow one its slack (and what forces move
// it), a fast one its slack about its swept motion.
double limit_of_s(const SolveInput& input, const Velocities& velocities, std::size_t i) {
  const double h_s = input.terms.dt_s;
  const SweptBounds& swept = input.motion.swept;
  const Vec3 motion = planned_motion_m(velocities, i, h_s);
  const double slack_m = swept_slack_m(input.scene, i);
  if (swept.fast(static_cast<std::uint32_t>(i))) {
    const Vec3& foreseen = swept.bounds[swept.bound_of[i]].motion_m;
    if ((motion - foreseen).norm() <= slack_m) return h_s;
    return h_s * std::min(1.0, slack_m / std::max(motion.norm(), slack_m));
  }
  const double may_m = slack_m + (0.5 * h_s * h_s) * velocities.acceleration_of(i).linear_mps2.norm();
  const double length = motion.norm();
  return length <= may_m ? h_s : h_s * (may_m / length);
}

std::uint32_t trajectory_of(const SolveInput& input, std::uint32_t slot, Velocities& velocities) {
  const double h_s = input.terms.dt_s;
  SweptContacts& swept = velocities.swept;
  std::uint32_t& index = swept.trajectory_of[slot];
  if (index != SweptContacts::kNone) return index;
  index = static_cast<std::uint32_t>(swept.trajectories.size());
  const dynamics::BodyStore& bodies = input.scene.bodies;
  Trajectory trajectory;
  trajectory.slot = slot;
  trajectory.dynamic = bodies.dynamic[slot] != 0;
  trajectory.start.shape = bodies.shape[slot].get();
  trajectory.start.position_m = bodies.position(slot);
  trajectory.start.rotation.orientation = dynamics::principal_to_world(bodies, slot);
  trajectory.stands = trajectory.start;
  trajectory.stop_s = 0;
  if (trajectory.dynamic) {
    trajectory.stop_s = swept.limit_s[slot];
    trajectory.start.velocity_mps = planned_motion_m(velocities, slot, h_s) / h_s;
    trajectory.start.rotation.spin_radps = velocities.bodies[slot].spin_radps;
    trajectory.start.moments_kgm2 = bodies.principal_kgm2[slot];
    if (trajectory.stop_s < h_s) {
      trajectory.stopped = true;
      trajectory.stands = collision::moved_on(trajectory.start, trajectory.stop_s);
      trajectory.velocity_mps = velocity_at_mps(velocities, slot, trajectory.stop_s, h_s);
    }
  }
  if (bodies.moves_by_itself(slot)) drive_trajectory(bodies, slot, h_s, trajectory);
  swept.trajectories.push_back(trajectory);
  return index;
}

// Where a body is on its trajectory. One that stands neither moves nor turns, whatever its velocity.
MovingBody moving_body_at(const Trajectory& trajectory, double time_s) {
  if (time_s >= trajectory.stop_s) {
    MovingBody stands = trajectory.stands;
    stands.velocity_mps = Vec3::Zero();
    stands.rotation.spin_radps = Vec3::Zero();
    stands.moments_kgm2 = Vec3::Zero();
    return stands;
  }
  return time_s > 0 ? collision::moved_on(trajectory.start, time_s) : trajectory.start;
}

// All searches of a step share so many pairs of nodes, but each has the least of them. Chosen: where hundreds of bodies
// spin at 1e8 rad/s each search goes to its limit, and a step took seconds.
constexpr std::size_t kNodePairsOfStep = std::size_t{1} << 19U, kLeastNodePairs = std::size_t{1} << 11U;

std::uint32_t node_pairs_of_search(std::size_t searches) {
  const std::size_t share = std::max(kLeastNodePairs, kNodePairsOfStep / std::max<std::size_t>(1, searches));
  return static_cast<std::uint32_t>(std::min<std::size_t>(share, collision::ImpactTerms{}.max_node_pairs));
}

// The first time of impact of two trajectories from a moment on, piece by piece between their stops.
TimeOfImpact impact_of(const Trajectory& a, const Trajectory& b, double from_s, double until_s,
                       collision::ImpactTerms terms) {
  TimeOfImpact impact;
  double time_s = from_s;
  while (time_s < until_s) {
    double next_s = until_s;
    bool moves = false;
    for (const double stop_s : {a.stop_s, b.stop_s}) {
      if (stop_s <= time_s) continue;
      moves = true;
      next_s = std::min(next_s, stop_s);
    }
    if (!moves) break;
    terms.duration_s = next_s - time_s;
    impact = collision::first_time_of_impact(moving_body_at(a, time_s), moving_body_at(b, time_s), terms);
    if (impact.kind != TimeOfImpact::Kind::None) {
      impact.time_s += time_s;
      return impact;
    }
    time_s = next_s;
  }
  impact.kind = TimeOfImpact::Kind::None;
  return impact;
}

// The events of one step in order of time.
class Events {
 public:
  Events(const SolveInput& input, Velocities& velocities, collision::FrontPool& scratch, FrameReport& report)
      : input_(input),
        pairs_(input.table.swept),
        velocities_(velocities),
        swept_(velocities.swept),
        scratch_(scratch),
        h_s_(input.terms.dt_s),
        report_(report) {}

  void run(parallel::Executor& executor) {
    list_trajectories();
    const std::size_t count = pairs_.size();
    swept_.times_of_impact.resize(count);
    swept_.looks.assign(count, 0);
    parallel::parallel_for(executor, count, 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) swept_.times_of_impact[k] = look(static_cast<std::uint32_t>(k), 0);
    });
    swept_.queue.clear();
    for (std::uint32_t k = 0; k < count; ++k) wait_for(k);
    while (!swept_.queue.empty()) {
      std::pop_heap(swept_.queue.begin(), swept_.queue.end(), later);
      const SweptEvent event = swept_.queue.back();
      swept_.queue.pop_back();
      if (event.look == swept_.looks[event.pair]) happen(event.pair);
    }
  }

 private:
  static bool later(const SweptEvent& x, const SweptEvent& y) {
    return x.time_s > y.time_s || (x.time_s == y.time_s && x.pair > y.pair);
  }

  [[nodiscard]] const ActivePair& pair_of(std::uint32_t k) const { return input_.table.pairs[pairs_[k].pair]; }
  [[nodiscard]] Trajectory& trajectory(std::uint32_t slot) const {
    return swept_.trajectories[swept_.trajectory_of[slot]];
  }

  void list_trajectories() {
    for (const SweptPair& pair : pairs_) {
      trajectory_of(input_, input_.table.pairs[pair.pair].a, velocities_);
      trajectory_of(input_, input_.table.pairs[pair.pair].b, velocities_);
    }
    swept_.pairs_begin.assign(swept_.trajectories.size() + 1, 0);
    const auto each = [&](auto&& use) {
      for (std::uint32_t k = 0; k < pairs_.size(); ++k) {
        for (const std::uint32_t slot : {pair_of(k).a, pair_of(k).b}) use(swept_.trajectory_of[slot], k);
      }
    };
    each([&](std::uint32_t c, std::uint32_t) { ++swept_.pairs_begin[c + 1]; });
    for (std::size_t c = 1; c < swept_.pairs_begin.size(); ++c) swept_.pairs_begin[c] += swept_.pairs_begin[c - 1];
    swept_.pairs_of.resize(2 * pairs_.size());
    each([&](std::uint32_t c, std::uint32_t k) { swept_.pairs_of[swept_.pairs_begin[c]++] = k; });
    // Each begin has moved on to its end.
    std::copy_backward(swept_.pairs_begin.begin(), swept_.pairs_begin.end() - 1, swept_.pairs_begin.end());
    swept_.pairs_begin[0] = 0;
  }

  [[nodiscard]] TimeOfImpact look(std::uint32_t k, double from_s) const {
    collision::ImpactTerms terms;
    terms.tolerance_m = pairs_[k].tolerance_m;
    terms.max_node_pairs = node_pairs_of_search(pairs_.size());
    return impact_of(trajectory(pair_of(k).a), trajectory(pair_of(k).b), from_s, h_s_, terms);
  }

  void wait_for(std::uint32_t k) {
    const TimeOfImpact& impact = swept_.times_of_impact[k];
    if (impact.kind == TimeOfImpact::Kind::None) return;
    swept_.queue.push_back({impact.time_s, k, swept_.looks[k]});
    std::push_heap(swept_.queue.begin(), swept_.queue.end(), later);
  }

  bool stop(Trajectory& trajectory, const MovingBody& where, double time_s) {
    if (!trajectory.dynamic || trajectory.stop_s <= time_s) return false;
    trajectory.velocity_mps = velocity_at_mps(velocities_, trajectory.slot, time_s, h_s_);
    trajectory.stop_s = time_s;
    trajectory.stopped = true;
    trajectory.stands = where;
    return true;
  }

  void happen(std::uint32_t k) {
    const TimeOfImpact impact = swept_.times_of_impact[k];
    const ActivePair& pair = pair_of(k);
    Trajectory& a = trajectory(pair.a);
    Trajectory& b = trajectory(pair.b);
    const bool stopped_a = stop(a, impact.a, impact.time_s);
    const bool stopped_b = stop(b, impact.b, impact.time_s);
    ++swept_.looks[k];
    if (impact.kind == TimeOfImpact::Kind::Cut) {
      ++report_.swept_cut;
    } else {
      answer(k, impact, a, b);
    }
    if (stopped_a) look_again(pair.a, impact.time_s, k);
    if (stopped_b) look_again(pair.b, impact.time_s, k);
  }

  void look_again(std::uint32_t slot, double time_s, std::uint32_t but) {
    const std::uint32_t c = swept_.trajectory_of[slot];
    for (std::uint32_t i = swept_.pairs_begin[c]; i < swept_.pairs_begin[c + 1]; ++i) {
      const std::uint32_t k = swept_.pairs_of[i];
      if (k == but) continue;
      ++swept_.looks[k];
      swept_.times_of_impact[k] = look(k, time_s);
      wait_for(k);
    }
  }

  [[nodiscard]] Mat3 inverse_inertia(const Trajectory& trajectory) const {
    if (!trajectory.dynamic) return Mat3::Zero();
    const Mat3 turn = trajectory.stands.rotation.orientation.toRotationMatrix();
    return turn * input_.scene.bodies.principal_kgm2[trajectory.slot].cwiseInverse().asDiagonal() * turn.transpose();
  }

  // Where two bodies slip against each other.
  struct FrictionAt {
    Vec3 normal, arm_a_m, arm_b_m;
    Mat3 inverse_inertia_a, inverse_inertia_b;
  };
  // Coulomb friction: what stops the slip, or as much as `most_ns`. What b received.
  static Vec3 apply_friction(const FrictionAt& at, double most_ns, solver::SolverBody& a, solver::SolverBody& b) {
    Vec3 slip = b.velocity_mps + b.spin_radps.cross(at.arm_b_m) - a.velocity_mps - a.spin_radps.cross(at.arm_a_m);
    slip -= slip.dot(at.normal) * at.normal;
    const double speed = slip.norm();
    if (!(most_ns > 0) || !(speed > 0)) return Vec3::Zero();
    const Vec3 across = -slip / speed;
    solver::Wrench wrench{across, at.arm_a_m.cross(across), at.arm_b_m.cross(across)};
    solver::Turns turns;
    if (!solver::prepare_wrench(a.inverse_mass, at.inverse_inertia_a, b.inverse_mass, at.inverse_inertia_b, wrench,
                                turns))
      return Vec3::Zero();
    const double impulse_ns = std::min(most_ns, speed * wrench.effective_mass);
    solver::apply_impulse(wrench, turns, impulse_ns, a, b);
    return impulse_ns * across;
  }

  // One impulse and its friction, as solve_impacts gives them.
  void answer(std::uint32_t k, const TimeOfImpact& impact, Trajectory& a, Trajectory& b) {
    const ActivePair& pair = pair_of(k);
    const dynamics::BodyStore& bodies = input_.scene.bodies;
    const PairRefiner refiner{input_.scene, input_.terms.contact};
    const collision::PairContact contact = contact_where_met(refiner, pair, impact, scratch_);
    solver::Wrench wrench{contact.direction, contact.moment_a_m, contact.moment_b_m};
    solver::Turns turns;
    if (!solver::prepare_wrench(bodies.inverse_mass[pair.a], inverse_inertia(a), bodies.inverse_mass[pair.b],
                                inverse_inertia(b), wrench, turns)) {
      ++report_.degenerate;
      return;
    }
    solver::SolverBody body_a;
    solver::SolverBody body_b;
    body_a.inverse_mass = bodies.inverse_mass[pair.a];
    body_b.inverse_mass = bodies.inverse_mass[pair.b];
    body_a.velocity_mps = a.velocity_mps;
    body_a.spin_radps = a.stands.rotation.spin_radps;
    body_b.velocity_mps = b.velocity_mps;
    body_b.spin_radps = b.stands.rotation.spin_radps;
    const double closing = solver::approach_mps(wrench, body_a, body_b);
    // A body that stands since it was hit may have a velocity away from what has reached it: that one then only stops.
    if (closing <= 0) return;
    const Material material = input_.scene.mixed_material(pair.a, pair.b);
    const double e = material.restitution;
    const double still = solver::still_mps(input_.settings());
    const double lambda = (1.0 + (e * closing > still ? e : 0.0)) * closing * wrench.effective_mass;
    solver::apply_impulse(wrench, turns, lambda, body_a, body_b);
    const double length = contact.direction.norm();
    const FrictionAt friction{contact.direction / length, contact.arm_m,
                              contact.arm_m - (impact.b.position_m - impact.a.position_m), inverse_inertia(a),
                              inverse_inertia(b)};
    const Vec3 across_ns = apply_friction(friction, material.friction * lambda * length, body_a, body_b);
    take(a, body_a);
    take(b, body_b);
    swept_.hits.push_back({pairs_[k].pair, friction.normal, impact.a.position_m + contact.arm_m, impact.contact.gap_m,
                           lambda * contact.direction + across_ns});
    ++report_.swept_hits;
  }

  static void take(Trajectory& trajectory, const solver::SolverBody& body) {
    if (!trajectory.dynamic) return;
    trajectory.velocity_mps = body.velocity_mps;
    trajectory.stands.rotation.spin_radps = body.spin_radps;
  }

  const SolveInput& input_;
  const std::vector<SweptPair>& pairs_;
  Velocities& velocities_;
  SweptContacts& swept_;
  collision::FrontPool& scratch_;
  double h_s_;
  FrameReport& report_;
};

}  // namespace

void solve_swept(const SolveInput& input, Velocities& velocities, collision::FrontPool& scratch, FrameReport& report,
                 parallel::Executor& executor) {
  SweptContacts& swept = velocities.swept;
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const std::size_t slots = bodies.slot_count();
  const double dt_s = input.terms.dt_s;
  swept.limit_s.resize(slots);
  swept.trajectory_of.assign(slots, SweptContacts::kNone);
  parallel::parallel_for(executor, slots, kTrajectoryGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i)
      swept.limit_s[i] = bodies.dynamic[i] != 0 ? limit_of_s(input, velocities, i) : 0.0;
  });
  for (std::uint32_t i = 0; i < slots; ++i) {
    if (bodies.dynamic[i] != 0 && swept.limit_s[i] < dt_s) trajectory_of(input, i, velocities);
  }
  Events(input, velocities, scratch, report).run(executor);
  for (const Trajectory& trajectory : swept.trajectories) {
    if (!trajectory.stopped) continue;
    velocities.bodies[trajectory.slot].velocity_mps = trajectory.velocity_mps;
    velocities.bodies[trajectory.slot].spin_radps = trajectory.stands.rotation.spin_radps;
  }
}

}  // namespace poise::simulation
