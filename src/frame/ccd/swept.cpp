// SPDX-License-Identifier: MIT
#include "frame/ccd/swept.h"

#include <algorithm>

#include "frame/refine/refine_level.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// Gaps below this share of the smaller extent count as touching. Chosen: a hundredth of a percent of a bullet's path,
// and far above rounding.
constexpr double kToleranceOfExtent = 1e-3;
// Pairs within this many tolerances at the start get a contact: a hit stops at half a tolerance to one.
constexpr double kTouching = 1.5;
// Below this share of the tolerance a gap is none.
constexpr double kOverlapping = 1.0 / 64;
// Pairs that are within the tolerance at the start meet when their gap has come down to this share of itself.
constexpr double kHitOfGap = 0.75;
// A swept bound is larger for skin and rounding, as a share of the radius.
constexpr double kEnlarged = 5e-3;

bool is_lone_ball(const Shape& shape) {
  return shape.kind == ShapeKind::Tree && !shape.surface && shape.tree.node_count() == 1;
}

Vec3 acceleration_of(const PredictInput& input, std::size_t i) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  Vec3 acceleration = input.terms.gravity_mps2;
  if (bodies.pushed[i] != 0) acceleration += bodies.inverse_mass[i] * bodies.force(i);
  return acceleration;
}

collision::MovingBody standing_body(const dynamics::BodyStore& bodies, std::uint32_t slot) {
  collision::MovingBody body;
  body.shape = bodies.shape[slot].get();
  body.position_m = bodies.position(slot);
  body.rotation.orientation = dynamics::principal_to_world(bodies, slot);
  return body;
}

// The one contact that is there. What a hit leaves between the surfaces is no gap to close.
void touch_exactly(const PredictedMotion& motion, const collision::ConvexGap& gap, double near_m,
                   const ActivePair& pair, collision::PairLevel& level, collision::LevelContact& found) {
  level.level = level.deepest;
  level.polygons = false;
  collision::PairContact& contact = found.contact;
  contact = {};
  contact.present = true;
  contact.direction = gap.normal;
  contact.arm_m = gap.point_m - motion.poses[pair.a].position_m;
  contact.moment_a_m = contact.arm_m.cross(gap.normal);
  contact.moment_b_m = (gap.point_m - motion.poses[pair.b].position_m).cross(gap.normal);
  contact.spheres_m = contact.estimated_separation_m = std::min(0.0, gap.gap_m - near_m);
  contact.certain_separation_m = 0;
  found.manifold_points.count = 0;
}

void take_pair(const CoarseInput& input, PairTable& table, SweptPair& swept, collision::FrontPool& pool) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  ActivePair& pair = table.pairs[swept.pair];
  PairStart& start = table.start[swept.pair];
  const double extent =
      std::min(input.scene.facts_of(pair.a).least_extent_m, input.scene.facts_of(pair.b).least_extent_m);
  swept.tolerance_m = kToleranceOfExtent * extent;
  const double near_m = kTouching * swept.tolerance_m;
  const collision::ConvexGap gap =
      collision::surface_gap(standing_body(bodies, pair.a), standing_body(bodies, pair.b), near_m);
  // Whatever is known of it, its trajectory is not the margin's business.
  pair.margin_m = pair.reach_m = pair.skin_m;
  start.cached = CacheUse::None;
  if (gap.gap_m <= kOverlapping * swept.tolerance_m) {
    swept.tolerance_m = 0;
    return;
  }
  // What slides along at less than the tolerance must not meet the neighbours of what it slides on.
  swept.tolerance_m = std::min(swept.tolerance_m, kHitOfGap * gap.gap_m);
  PairProgress& progress = swept.progress = PairProgress(start);
  progress.exact = true;
  if (gap.gap_m >= near_m || gap.normal.isZero(0)) {
    progress.level.apart = true;
  } else if (is_lone_ball(*bodies.shape[pair.a]) ||
             (bodies.shape[pair.b]->kind == ShapeKind::Tree && is_lone_ball(*bodies.shape[pair.b]))) {
    touch_exactly(input.motion, gap, near_m, pair, progress.level, swept.contact);
  } else {
    const PairRefiner refiner{input.scene, input.terms.contact};
    refine_whole(refiner, posed(input.motion, pair), progress, swept.contact, pool);
  }
  progress.level.deepest = progress.level.level;
  start.deepest = 0;  // nothing is left to refine
  pair.reach_m = 0;   // another frame must find it anew
}

}  // namespace

double swept_slack_m(const SceneView& scene, std::size_t slot) { return 0.5 * scene.facts_of(slot).least_extent_m; }

void begin_swept(const PredictInput& input, SweptBounds& swept) {
  swept.on = input.terms.backtracking;
  swept.bounds.clear();
  swept.bound_of.assign(input.scene.bodies.slot_count(), SweptBounds::kNone);
}

bool sweep_if_fast(const PredictInput& input, std::uint32_t slot, SweptBounds& swept) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  if (bodies.dynamic[slot] == 0) return false;
  const double h = input.terms.dt_s;
  // What gravity adds in a step does not make a body fast that has only begun to fall; what the caller does to it does.
  const double slack_m = swept_slack_m(input.scene, slot);
  Vec3 velocity_mps = bodies.velocity(slot);
  if (bodies.pushed[slot] != 0) velocity_mps += 0.5 * h * bodies.inverse_mass[slot] * bodies.force(slot);
  if (velocity_mps.norm() * h <= slack_m) return false;
  collision::SweptBound bound;
  const double radius = bodies.shape[slot]->bounding_radius_m * (1.0 + kEnlarged) + slack_m;
  bound.start = {bodies.position(slot), radius, slot, bodies.group[slot], bodies.collides_with[slot], true};
  bound.motion_m = h * bodies.velocity(slot) + (0.5 * h * h) * acceleration_of(input, slot);
  swept.bound_of[slot] = static_cast<std::uint32_t>(swept.bounds.size());
  swept.bounds.push_back(bound);
  return true;
}

void take_swept_pairs(const CoarseInput& input, PairTable& table, std::span<collision::FrontPool> pools,
                      parallel::Executor& executor) {
  const SweptBounds& swept = input.motion.swept;
  if (swept.bounds.empty()) return;
  for (std::uint32_t k = 0; k < table.pairs.size(); ++k) {
    if (swept.fast(table.pairs[k].low()) || swept.fast(table.pairs[k].high())) table.swept.push_back({k, 0, {}, {}});
  }
  parallel::parallel_for(executor, table.swept.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t i = begin; i < end; ++i)
      take_pair(input, table, table.swept[i], pools[static_cast<std::size_t>(worker)]);
  });
  std::erase_if(table.swept, [](const SweptPair& pair) { return pair.tolerance_m == 0; });
}

}  // namespace poise::simulation
