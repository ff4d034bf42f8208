// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "frame/refine/score_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "frame/cues/known_separation.h"
#include "frame/refine/score_lanes.h"
#include "math/functions.h"
#include "poise/scheduler/cues.h"
#include "solver/lane_math_inl.h"

HWY_BEFORE_NAMESPACE();
namespace poise::simulation::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace lanes = solver::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kScoredAtOnce>;
using V = hn::Vec<Doubles>;
using Three = lanes::Triple<V>;

HWY_INLINE Three all(Doubles d, const Vec3& of) { return {hn::Set(d, of.x()), hn::Set(d, of.y()), hn::Set(d, of.z())}; }
HWY_INLINE Three choose(const hn::Mask<Doubles>& which, const Three& yes, const Three& no) {
  return {hn::IfThenElse(which, yes.x, no.x), hn::IfThenElse(which, yes.y, no.y), hn::IfThenElse(which, yes.z, no.z)};
}
HWY_INLINE Three negative(const Three& a) { return {hn::Neg(a.x), hn::Neg(a.y), hn::Neg(a.z)}; }
HWY_INLINE hn::Mask<Doubles> set_in(Doubles d, const double* flags) { return hn::Gt(hn::Load(d, flags), hn::Zero(d)); }

// As scheduler::bounded.
HWY_INLINE V bounded(Doubles d, V x, double most) { return hn::Min(hn::Max(hn::Zero(d), x), hn::Set(d, most)); }

// As scheduler::raised.
HWY_INLINE V raised(Doubles d, V base, double exponent) {
  if (exponent == 0) return hn::Set(d, 1);
  V power = base;
  if (exponent == 2) {
    power = hn::Mul(base, base);
  } else if (exponent != 1) {
    alignas(64) double each[kScoredAtOnce];
    hn::Store(base, d, each);
    for (std::size_t k = 0; k < hn::Lanes(d); ++k) each[k] = math::pow(each[k], exponent);
    power = hn::Load(d, each);
  }
  return hn::Min(power, hn::Set(d, scheduler::kMostFactor));
}

// Of -1 to 1: Abramowitz and Stegun (1964), 4.4.46.
HWY_INLINE V arc_cosine(Doubles d, V x) {
  constexpr double kCoefficients[] = {1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
                                      0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911};
  const V size = hn::Min(hn::Abs(x), hn::Set(d, 1));
  V sum = hn::Set(d, kCoefficients[7]);
  for (std::size_t k = 7; k-- > 0;) sum = hn::Add(hn::Mul(sum, size), hn::Set(d, kCoefficients[k]));
  const V angle = hn::Mul(hn::Sqrt(hn::Sub(hn::Set(d, 1), size)), sum);
  return hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, 3.14159265358979323846), angle), angle);
}

// Where the pairs of some lanes meet, and what moves there.
struct PlaceLanes {
  Three point, normal;
  V closing_mps;
  V separation_m;  // of the root spheres
};

// As place_of, surface_closing_mps and coarsest_separation_m.
HWY_INLINE PlaceLanes place(Doubles d, const LaneTerms& terms, const LanePairs& pairs, std::size_t lane) {
  const std::uint32_t* const slots_a = pairs.a + lane;
  const std::uint32_t* const slots_b = pairs.b + lane;
  const lanes::Columns<V> at_a = lanes::gather(d, terms.bounds, slots_a, 0);
  const lanes::Columns<V> root_a = lanes::gather(d, terms.bounds, slots_a, 4);
  const lanes::Columns<V> motion_a = lanes::gather(d, terms.bounds, slots_a, 8);
  const lanes::Columns<V> at_b = lanes::gather(d, terms.bounds, slots_b, 0);
  const lanes::Columns<V> root_b = lanes::gather(d, terms.bounds, slots_b, 4);
  const lanes::Columns<V> motion_b = lanes::gather(d, terms.bounds, slots_b, 8);
  const Three position_a = {at_a.at[0], at_a.at[1], at_a.at[2]};
  const Three position_b = {at_b.at[0], at_b.at[1], at_b.at[2]};  // of a plane: its normal
  const Three center_a = {root_a.at[0], root_a.at[1], root_a.at[2]};
  const Three center_b = {root_b.at[0], root_b.at[1], root_b.at[2]};
  const V radius_a = root_a.at[3];
  const V radius_b = root_b.at[3];
  const auto plane = set_in(d, pairs.with_plane + lane);

  const Three between = lanes::difference(center_b, center_a);
  const V distance = hn::Sqrt(lanes::dot(between, between));
  const auto apart = hn::Gt(distance, hn::Zero(d));
  const V per_distance = hn::Div(hn::Set(d, 1), hn::IfThenElse(apart, distance, hn::Set(d, 1)));
  const Three direction =
      choose(apart, lanes::scaled(per_distance, between), {hn::Zero(d), hn::Zero(d), hn::Set(d, 1)});
  PlaceLanes at;
  at.normal = choose(plane, negative(position_b), direction);
  const auto by_a = hn::Or(plane, hn::Le(radius_a, radius_b));
  const V reach_a = hn::IfThenElse(plane, radius_a, hn::Min(radius_a, distance));
  at.point = choose(by_a, lanes::sum(center_a, lanes::scaled(reach_a, at.normal)),
                    lanes::difference(center_b, lanes::scaled(hn::Min(radius_b, distance), at.normal)));
  const V estimated = hn::IfThenElse(plane, at_b.at[3], motion_b.at[3]);  // of a plane: its height
  at.separation_m =
      hn::Sub(hn::Sub(hn::IfThenElse(plane, lanes::dot(position_b, center_a), distance), motion_a.at[3]), estimated);

  if (pairs.any_points) {
    const auto points = [&](std::size_t offset) HWY_ATTR {
      return lanes::columns_of(
          d, [&](std::size_t k) { return lanes::figures_at<const double>(pairs.point[lane + k], 0, offset); });
    };
    const lanes::Columns<V> normal = points(0);
    const lanes::Columns<V> on_a = points(4);
    // Rotations are columns, after the position.
    const auto turn = [&](const std::uint32_t* slots) HWY_ATTR {
      const lanes::Columns<V> first = lanes::gather(d, terms.poses, slots, 0);
      const lanes::Columns<V> second = lanes::gather(d, terms.poses, slots, 4);
      const lanes::Columns<V> third = lanes::gather(d, terms.poses, slots, 8);
      return lanes::Turn<V>{{{first.at[3], second.at[0], second.at[1]},
                             {second.at[2], second.at[3], third.at[0]},
                             {third.at[1], third.at[2], third.at[3]}}};
    };
    const auto known = set_in(d, pairs.with_points + lane);
    const Three arm_a = lanes::turned(turn(slots_a), Three{on_a.at[0], on_a.at[1], on_a.at[2]});
    at.point = choose(known, lanes::sum(position_a, arm_a), at.point);
    at.normal = choose(known, lanes::turned(turn(slots_b), Three{normal.at[0], normal.at[1], normal.at[2]}), at.normal);
  }

  const Three spin_a = lanes::load(d, pairs.spin_a, lane);
  const Three spin_b = lanes::load(d, pairs.spin_b, lane);
  const Three velocity_a = {motion_a.at[0], motion_a.at[1], motion_a.at[2]};
  const Three velocity_b = {motion_b.at[0], motion_b.at[1], motion_b.at[2]};
  const Three of_a = lanes::sum(velocity_a, lanes::cross(spin_a, lanes::difference(at.point, position_a)));
  const Three of_b = lanes::sum(velocity_b, lanes::cross(spin_b, lanes::difference(at.point, position_b)));
  at.closing_mps = hn::Max(hn::Zero(d), lanes::dot(at.normal, lanes::difference(of_a, of_b)));
  return at;
}

// What the viewer sees of them.
struct ViewLanes {
  V visibility, angle_radpm, eccentricity_rad;
};

// As cues_of.
HWY_INLINE ViewLanes view(Doubles d, const LaneTerms& terms, const PlaceLanes& at, V extent_m) {
  const ViewQuery& query = *terms.view;
  const scheduler::Policy& policy = *terms.policy;
  if (!query.view.present) return {hn::Set(d, 1), hn::Set(d, policy.plain_angle_radpm), hn::Zero(d)};
  const Three ray = lanes::difference(at.point, all(d, query.view.position_m));
  const V distance = hn::Max(hn::Sqrt(lanes::dot(ray, ray)), hn::Set(d, kNearestSeenM));
  const V per_distance = hn::Div(hn::Set(d, 1), distance);
  const Three direction = lanes::scaled(per_distance, ray);
  const V depth = lanes::dot(ray, all(d, query.view.forward));
  const auto beyond = [&](const Vec3& side, double tangent, double cosine) HWY_ATTR {
    const V across = hn::Abs(lanes::dot(ray, all(d, side)));
    return hn::Mul(hn::Sub(across, hn::Mul(depth, hn::Set(d, tangent))), hn::Set(d, cosine));
  };
  const auto inside = hn::And(hn::Ge(depth, hn::Neg(extent_m)),
                              hn::And(hn::Lt(beyond(query.up, query.tangent_up, query.per_up), extent_m),
                                      hn::Lt(beyond(query.right, query.tangent_right, query.per_right), extent_m)));
  ViewLanes seen;
  seen.visibility = hn::IfThenElse(inside, hn::Set(d, 1), hn::Set(d, policy.outside_frustum));
  const V along = hn::Min(hn::Set(d, 1), hn::Abs(lanes::dot(direction, at.normal)));
  const V across = hn::Sqrt(hn::Sub(hn::Set(d, 1), hn::Mul(along, along)));
  seen.angle_radpm = hn::Mul(hn::Max(hn::Set(d, kLeastAcross), across), per_distance);
  seen.eccentricity_rad = arc_cosine(d, lanes::dot(direction, all(d, query.view.gaze)));
  return seen;
}

// As the cue.
HWY_INLINE V touch(Doubles d, V separation_m, V error_m) {
  const V one = hn::Set(d, 1);
  const V most = hn::Set(d, scheduler::kMostFactor);
  const V z = hn::Max(hn::Neg(most), hn::Min(hn::Div(separation_m, hn::Max(error_m, hn::Set(d, kLeastErrorM))), most));
  const V root = hn::Sqrt(hn::Add(one, hn::Mul(z, z)));
  const V square = hn::IfThenElse(hn::Gt(z, hn::Zero(d)), hn::Div(one, hn::Mul(root, hn::Add(root, z))),
                                  hn::Sub(one, hn::Div(z, root)));
  return hn::Sqrt(square);
}

void score(const LaneTerms& terms, const LanePairs& pairs, LaneScores& scores) {
  const Doubles d;
  const scheduler::Policy& policy = *terms.policy;
  const V one = hn::Set(d, 1);
  for (std::size_t lane = 0; lane < kScoredAtOnce; lane += hn::Lanes(d)) {
    const PlaceLanes at = place(d, terms, pairs, lane);
    const ViewLanes seen = view(d, terms, at, hn::Load(d, pairs.extent_m + lane));
    const V separation_m =
        hn::IfThenElse(set_in(d, pairs.by_roots + lane), at.separation_m, hn::Load(d, pairs.separation_m + lane));
    const V most = hn::Set(d, scheduler::kMostFactor);
    const V eccentricity =
        hn::Div(one, hn::Add(one, hn::Div(seen.eccentricity_rad, hn::Set(d, policy.eccentricity_e2_rad))));
    const V closing = hn::Add(one, hn::Div(hn::Min(at.closing_mps, most), hn::Set(d, policy.closing_scale_mps)));
    V weight = raised(d, bounded(d, seen.visibility, 1), policy.frustum);
    const auto weigh = [&](V factor, double exponent) HWY_ATTR {
      if (exponent != 0) weight = hn::Mul(weight, raised(d, factor, exponent));
    };
    weigh(eccentricity, policy.eccentricity);
    weigh(closing, policy.closing);
    weigh(hn::Load(d, pairs.waiting + lane), policy.waiting);
    weigh(bounded(d, hn::Load(d, pairs.importance + lane), scheduler::kMostFactor), policy.importance);
    weigh(touch(d, separation_m, hn::Load(d, pairs.error_m + lane)), policy.touch);
    const V plain = hn::Set(d, policy.plain_angle_radpm);
    const V angle =
        hn::Mul(plain, raised(d, hn::Div(bounded(d, seen.angle_radpm, scheduler::kMostFactor), plain), policy.size));
    const V gain = hn::Mul(hn::Mul(hn::Set(d, policy.chance_of_ending), angle), hn::Load(d, pairs.gain_m + lane));
    hn::Store(bounded(d, hn::Mul(weight, gain), scheduler::kMostScore), d, scores.score + lane);
    hn::Store(hn::Mul(seen.visibility, seen.angle_radpm), d, scores.seen_radpm + lane);
  }
}

}  // namespace poise::simulation::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::simulation {
namespace {

// As place() reads them.
static_assert(offsetof(BodyBounds, root_center_m) == 4 * sizeof(double) &&
              offsetof(BodyBounds, velocity_mps) == 8 * sizeof(double) &&
              offsetof(collision::Pose, rotation) == 3 * sizeof(double) &&
              offsetof(solver::ContactPoint, on_a_m) == 4 * sizeof(double));

// What lanes without points read.
const solver::ContactPoint kNoPoint{};

}  // namespace

HWY_EXPORT(score);

void score_lanes(const LaneTerms& terms, const LanePairs& pairs, LaneScores& scores) {
  HWY_DYNAMIC_DISPATCH(score)(terms, pairs, scores);
}

bool scores_in_lanes(const scheduler::Policy& policy) {
  using scheduler::Policy;
  constexpr double Policy::*kOneByOne[] = {&Policy::occlusion, &Policy::gap,       &Policy::delay,     &Policy::onset,
                                           &Policy::crowding,  &Policy::attention, &Policy::hysteresis};
  const bool alone = std::ranges::any_of(kOneByOne, [&](double Policy::*weight) { return policy.*weight != 0; });
  return policy.kind == scheduler::PolicyKind::Perceptual && policy.cue.function == nullptr && !alone &&
         policy.learning == 0 && policy.time_price_rad == 0 && policy.seen_threshold_rad == 0;
}

LaneScorer::LaneScorer(const RefineInput& input)
    : input_(input),
      view_(input.step.view),
      terms_{input.motion.poses.data(), input.motion.body_bounds.data(), &input.policy, &view_} {}

void LaneScorer::score(std::span<const std::uint32_t> pairs, std::span<const PairProgress> progress, Scored& scored) {
  const std::size_t groups = (pairs.size() + kScoredAtOnce - 1) / kScoredAtOnce;
  // All of them before the first is scored: what was just written in parts cannot be read whole.
  for (std::size_t group = 0; group < groups; ++group) {
    pairs_[group].any_points = false;
    for (std::size_t lane = 0; lane < kScoredAtOnce; ++lane) {
      // Lanes without a pair score the last one again.
      const std::uint32_t index = pairs[std::min(group * kScoredAtOnce + lane, pairs.size() - 1)];
      gather(index, progress[index], pairs_[group], lane);
    }
  }
  for (std::size_t group = 0; group < groups; ++group) score_lanes(terms_, pairs_[group], scored.of_lanes[group]);
}

void LaneScorer::gather(std::uint32_t index, const PairProgress& progress, LanePairs& into, std::size_t lane) {
  const ActivePair& pair = input_.table.pairs[index];
  const CachedPair& cached = *pair.cached;
  const std::vector<double>& importance = input_.scene.bodies.importance;
  into.a[lane] = pair.a;
  into.b[lane] = pair.b;
  const bool points = cached.point_count > 0 && input_.points != nullptr;
  into.any_points = into.any_points || points;
  into.point[lane] = points ? &input_.points->points[PointCache::begin(cached.slot)] : &kNoPoint;
  into.with_points[lane] = points ? 1 : 0;
  into.with_plane[lane] = input_.motion.body_bounds[pair.b].plane ? 1 : 0;
  into.extent_m[lane] = pair.skin_m / kSkin;
  into.importance[lane] = static_cast<double>(static_cast<float>(importance[pair.a] * importance[pair.b]));
  into.waiting[lane] = 1.0 + static_cast<double>(cached.frames_waited);
  const Vec3& spin_a = input_.motion.spins_radps[pair.a];
  const Vec3& spin_b = input_.motion.spins_radps[pair.b];
  for (int axis = 0; axis < 3; ++axis) {
    into.spin_a[axis][lane] = spin_a[axis];
    into.spin_b[axis][lane] = spin_b[axis];
  }
  const OfShapes& shapes = of_shapes(pair, progress);
  const KnownSeparation known = known_separation_of(input_.scene, pair);
  into.by_roots[lane] = known.by_roots ? 1 : 0;
  into.separation_m[lane] = known.separation_m;
  into.error_m[lane] = known.error_m;
  if (progress.has_cached_points() || progress.cached == CacheUse::Parted) {
    const float moved_m = progress.cached == CacheUse::Points ? 0.0F : static_cast<float>(cached.moved_m);
    into.gain_m[lane] = gain_m(shapes, progress.cached_level, shapes.error_m[progress.cached_level] + moved_m);
  } else {
    into.gain_m[lane] = shapes.gain_m;
  }
}

double LaneScorer::gain_m(const OfShapes& shapes, std::size_t known_level, float known_m) {
  const auto error_m = [&](std::size_t level) {
    return level < known_level ? std::min(shapes.error_m[level], known_m) : shapes.error_m[level];
  };
  const auto now_m = static_cast<double>(error_m(0));
  double best = 0;
  for (std::size_t level = 1; level <= shapes.deepest; ++level)
    best = std::max(best, (now_m - static_cast<double>(error_m(level))) * shapes.of_work[level]);
  return best;
}

const LaneScorer::OfShapes& LaneScorer::of_shapes(const ActivePair& pair, const PairProgress& progress) {
  const ShapeFacts* const a = &input_.scene.facts_of(pair.a);
  const ShapeFacts* const b = &input_.scene.facts_of(pair.b);
  const collision::PairLevel& level = progress.level;
  if (shapes_.a == a && shapes_.b == b && shapes_.next_units == level.next_units && shapes_.deepest == level.deepest &&
      shapes_.polygons == level.polygons)
    return shapes_;
  shapes_.a = a;
  shapes_.b = b;
  shapes_.next_units = level.next_units;
  shapes_.deepest = level.deepest;
  shapes_.polygons = level.polygons;
  std::ranges::fill(shapes_.error_m, 0.0F);
  for (std::size_t k = 0; k < a->error_m.size(); ++k) shapes_.error_m[k] = a->error_m[k] + b->error_m[k];
  if (level.polygons) shapes_.error_m[level.deepest] = 0;
  double work = input_.policy.job_overhead_units;
  double front = static_cast<double>(level.next_units);
  for (std::size_t k = 1; k <= level.deepest; ++k) {
    work += std::max(front, 1.0);
    front *= input_.policy.front_growth;
    shapes_.of_work[k] = 1 / work;
  }
  shapes_.gain_m = gain_m(shapes_, 0, std::numeric_limits<float>::max());
  return shapes_;
}

}  // namespace poise::simulation
#endif
