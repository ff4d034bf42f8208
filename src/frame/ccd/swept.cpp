// SPDX-License-Identifier: MIT
#include "frame/ccd/swept.h"

#include <algorithm>

#include "frame/ccd/swept_contact.h"
#include "frame/stages.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// Gaps below this share of the smaller extent count as touching. Chosen: a hundredth of a percent of a bullet's way,
// and far above rounding.
constexpr double kToleranceOfExtent = 1e-3;
// Pairs within this many tolerances at the start make a row: a hit stands at half a tolerance to one.
constexpr double kTouching = 1.5;
// Below this share of the tolerance a gap is none.
constexpr double kOverlapping = 1.0 / 64;
// Pairs that are within the tolerance at the start meet when their gap has come down to this share of itself.
constexpr double kHitOfGap = 0.75;
// Room around a swept bound for skin and rounding, as a share of the radius.
constexpr double kSweptRoom = 5e-3;

bool is_lone_ball(const Shape& shape) {
  return shape.kind == ShapeKind::Tree && !shape.surface && shape.tree.node_count() == 1;
}

Vec3 acceleration_of(const WorldState& world, std::size_t i) {
  Vec3 acceleration = world.settings.gravity_mps2;
  if (world.bodies.pushed[i] != 0) acceleration += world.bodies.inverse_mass[i] * world.bodies.force(i);
  return acceleration;
}

collision::MovingBody standing_body(const WorldState& world, std::uint32_t slot) {
  collision::MovingBody moving_body;
  moving_body.shape = world.bodies.shape[slot].get();
  moving_body.position_m = world.bodies.position(slot);
  moving_body.rotation.orientation = dynamics::principal_to_world(world.bodies, slot);
  return moving_body;
}

// A row by the one contact that is there. What a hit leaves between the surfaces is no gap to close.
void touch_exactly(const WorldState& world, const collision::ConvexGap& gap, double near_m, ActivePair& pair,
                   collision::LevelContact& found) {
  const collision::Pose& pose = world.buffers.poses[pair.a];
  collision::PairLevel& level = pair.level;
  level.level = level.deepest;
  level.polygons = false;
  collision::PairContact& contact = found.contact;
  contact = {};
  contact.present = true;
  contact.direction = gap.normal;
  contact.arm_m = gap.point_m - pose.position_m;
  contact.moment_a_m = contact.arm_m.cross(gap.normal);
  contact.moment_b_m = (gap.point_m - world.buffers.poses[pair.b].position_m).cross(gap.normal);
  contact.spheres_m = contact.estimated_separation_m = std::min(0.0, gap.gap_m - near_m);
  contact.certain_separation_m = 0;
  found.manifold_points.count = 0;
}

void send(WorldState& world, SweptPair& swept, int worker) {
  ActivePair& pair = world.buffers.pairs[swept.pair];
  collision::LevelContact& found = world.buffers.found[swept.pair];
  const double extent = std::min(world.shapes[world.shape_of[pair.a]].least_extent_m,
                                 world.shapes[world.shape_of[pair.b]].least_extent_m);
  swept.tolerance_m = kToleranceOfExtent * extent;
  const double near_m = kTouching * swept.tolerance_m;
  const collision::ConvexGap gap =
      collision::surface_gap(standing_body(world, pair.a), standing_body(world, pair.b), near_m);
  // Whatever is known of it, its way is not the margin's business.
  pair.margin_m = pair.reach_m = pair.skin_m;
  pair.cached = CacheUse::None;
  if (gap.gap_m <= kOverlapping * swept.tolerance_m) {
    swept.tolerance_m = 0;
    return;
  }
  // What slides along at less than the tolerance must not meet the neighbours of what it slides on.
  swept.tolerance_m = std::min(swept.tolerance_m, kHitOfGap * gap.gap_m);
  pair.exact = true;
  if (gap.gap_m >= near_m || gap.normal.isZero(0)) {
    pair.level.apart = true;
  } else if (is_lone_ball(*world.bodies.shape[pair.a]) ||
             (world.bodies.shape[pair.b]->kind == ShapeKind::Tree && is_lone_ball(*world.bodies.shape[pair.b]))) {
    touch_exactly(world, gap, near_m, pair, found);
  } else {
    refine_whole(world, pair, found, worker);
  }
  pair.level.deepest = pair.level.level;
  pair.reach_m = 0;  // another frame must look anew
}

}  // namespace

void begin_swept(WorldState& world, const StepInput& input) {
  SweptFrame& swept = world.buffers.swept;
  swept.on = input.backtracking;
  swept.bounds.clear();
  swept.pairs.clear();
  swept.trajectories.clear();
  swept.hits.clear();
  swept.bound_of.assign(world.bodies.slot_count(), SweptFrame::kNone);
}

bool sweep_if_fast(WorldState& world, std::uint32_t slot, const StepInput& input) {
  const dynamics::BodyStore& bodies = world.bodies;
  if (bodies.dynamic[slot] == 0) return false;
  // By the speed alone: what gravity adds in a step does not make a body fast that has only begun to fall.
  const double slack_m = swept_slack_m(world, slot);
  if (bodies.velocity(slot).norm() * input.dt_s <= slack_m) return false;
  const double h = input.dt_s;
  collision::SweptBound bound;
  const double radius = bodies.shape[slot]->bounding_radius_m * (1.0 + kSweptRoom) + slack_m;
  bound.start = {bodies.position(slot), radius, slot, bodies.group[slot], bodies.collides_with[slot], true};
  bound.motion_m = h * bodies.velocity(slot) + (0.5 * h * h) * acceleration_of(world, slot);
  SweptFrame& swept = world.buffers.swept;
  swept.bound_of[slot] = static_cast<std::uint32_t>(swept.bounds.size());
  swept.bounds.push_back(bound);
  return true;
}

void send_swept(WorldState& world, const StepInput&, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  SweptFrame& swept = buffers.swept;
  if (swept.bounds.empty()) return;
  for (std::uint32_t k = 0; k < buffers.pairs.size(); ++k) {
    if (swept.fast(buffers.pairs[k].low()) || swept.fast(buffers.pairs[k].high())) swept.pairs.push_back({k, 0});
  }
  parallel::parallel_for(*world.executor, swept.pairs.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t i = begin; i < end; ++i) send(world, swept.pairs[i], worker);
  });
  std::erase_if(swept.pairs, [](const SweptPair& pair) { return pair.tolerance_m == 0; });
  report.swept_pairs = swept.pairs.size();
}

bool place_stopped(WorldState& world, std::uint32_t slot) {
  const SweptFrame& swept = world.buffers.swept;
  if (swept.trajectories.empty() || swept.trajectory_of[slot] == SweptFrame::kNone) return false;
  const Trajectory& trajectory = swept.trajectories[swept.trajectory_of[slot]];
  if (!trajectory.stopped) return false;
  dynamics::BodyStore& bodies = world.bodies;
  const double sine =
      (trajectory.stands.rotation.orientation * trajectory.start.rotation.orientation.conjugate()).vec().norm();
  world.buffers.motions[slot] = {trajectory.stands.position_m - trajectory.start.position_m,
                                 2.0 * bodies.shape[slot]->bounding_radius_m * sine};
  bodies.set_position(slot, trajectory.stands.position_m);
  bodies.set_orientation(
      slot, (trajectory.stands.rotation.orientation * bodies.shape[slot]->principal_axes.conjugate()).normalized());
  bodies.set_velocity(slot, trajectory.velocity_mps);
  bodies.set_spin(slot, trajectory.stands.rotation.spin_radps);
  bodies.set_force(slot, Vec3::Zero());
  bodies.set_torque(slot, Vec3::Zero());
  bodies.pushed[slot] = 0;
  return true;
}

}  // namespace poise::simulation
