// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/contacts/fill_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <array>
#include <cstddef>

#include "collision/manifold/manifold_point.h"
#include "solver/contacts/fill_lanes.h"
#include "solver/lane_math_inl.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Pairs in double precision; lanes of either precision are beside them.
using Doubles = hn::CappedTag<double, kLanes>;
using V = hn::Vec<Doubles>;

HWY_INLINE void put(Doubles d, const V& value, double* to) { hn::Store(value, d, to); }
HWY_INLINE void put(Doubles d, const V& value, float* to) {
  const hn::Rebind<float, Doubles> singles;
  (void)d;
  hn::Store(hn::DemoteTo(singles, value), singles, to);
}
HWY_INLINE V get(Doubles d, const double* from) { return hn::Load(d, from); }
HWY_INLINE V get(Doubles d, const float* from) {
  const hn::Rebind<float, Doubles> singles;
  return hn::PromoteTo(d, hn::Load(singles, from));
}
template <class T>
HWY_INLINE void put(Doubles d, const Triple<V>& value, T (*to)[kLanes], std::size_t lane) {
  put(d, value.x, to[0] + lane);
  put(d, value.y, to[1] + lane);
  put(d, value.z, to[2] + lane);
}
template <class T>
HWY_INLINE Triple<V> get(Doubles d, const T (*from)[kLanes], std::size_t lane) {
  return {get(d, from[0] + lane), get(d, from[1] + lane), get(d, from[2] + lane)};
}

// Where some bodies are.
struct Poses {
  Triple<V> position;
  Turn<V> rotation;
};
// Made in its place, figure by figure: GCC 12 copies whole structures through memory.
HWY_INLINE void read_poses(Doubles d, const collision::Pose* const* of, Poses& into) {
  static_assert(sizeof(collision::Pose) == 12 * sizeof(double));
  const auto quad = [&](std::size_t offset) HWY_ATTR {
    return columns_of(d, [&](std::size_t lane) { return figures_at<const double>(of[lane], 0, offset); });
  };
  const Columns<V> one = quad(0);
  const Columns<V> two = quad(4);
  const Columns<V> three = quad(8);
  const auto set = [](Triple<V>& to, const V& x, const V& y, const V& z) HWY_ATTR {
    to.x = x;
    to.y = y;
    to.z = z;
  };
  set(into.position, one.at[0], one.at[1], one.at[2]);
  set(into.rotation.column[0], one.at[3], two.at[0], two.at[1]);
  set(into.rotation.column[1], two.at[2], two.at[3], three.at[0]);
  set(into.rotation.column[2], three.at[1], three.at[2], three.at[3]);
}

// The lanes of a register whose bits are set, from a lane of the block on.
HWY_INLINE hn::Mask<Doubles> lanes_of(Doubles d, std::uint32_t bits, std::size_t lane) {
  // Bytes, from which Highway may read more than there are lanes.
  const std::uint8_t some[8] = {static_cast<std::uint8_t>(bits >> lane)};
  return hn::LoadMaskBits(d, some);
}

struct Bodies {
  Triple<V> velocity, spin;
  V inverse_mass;
};
HWY_INLINE Bodies bodies_of(Doubles d, const SolverBody* const* of) {
  const auto quad = [&](std::size_t offset) HWY_ATTR {
    return columns_of(d, [&](std::size_t lane) { return figures_at<const double>(of[lane], 0, offset); });
  };
  const Columns<V> one = quad(0);
  const Columns<V> two = quad(4);
  return {{one.at[0], one.at[1], one.at[2]}, {one.at[3], two.at[0], two.at[1]}, two.at[2]};
}

// Four numbers of a pair end with its friction, restitution and slop.
constexpr std::size_t kBeforeFriction = 2;
static_assert(offsetof(Manifold, friction) == (kBeforeFriction + 1) * sizeof(double) &&
              sizeof(Manifold) == (kBeforeFriction + 4) * sizeof(double));

// What pairs have where others have more contact points.
struct NoPoints {
  NoPoints() {
    for (ContactPoint& point : points) point.normal.setZero();
  }
  std::array<ContactPoint, collision::kMaxManifoldPoints> points;
  std::array<ContactForce, collision::kMaxManifoldPoints> forces;
};

template <class T>
void fill(const LaneSources& sources, PairLanes<T>& shared, StartLanes<T>& start,
          std::span<PointLanes<T>> manifold_points) {
  static const NoPoints none;
  const Doubles d;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1.0);
  const V half = hn::Set(d, 0.5);
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
    const Bodies a = bodies_of(d, sources.a + lane);
    const Bodies b = bodies_of(d, sources.b + lane);
    const V inverse_mass = hn::Add(a.inverse_mass, b.inverse_mass);
    // As share_of_gap.
    const V share =
        hn::IfThenElse(hn::Eq(b.inverse_mass, zero), zero, hn::IfThenElse(hn::Eq(a.inverse_mass, zero), one, half));
    const auto moves = hn::Gt(inverse_mass, zero);
    const V unit_kg = hn::IfThenElseZero(moves, hn::Div(one, hn::IfThenElse(moves, inverse_mass, one)));
    put(d, hn::Mul(unit_kg, a.inverse_mass), shared.dynamic_a + lane);
    put(d, hn::Mul(unit_kg, b.inverse_mass), shared.dynamic_b + lane);
    put(d, unit_kg, shared.reduced_mass + lane);
    const Columns<V> pair = columns_of(
        d, [&](std::size_t k) { return figures_at<const double>(sources.pairs[lane + k], 0, kBeforeFriction); });
    put(d, pair.at[1], shared.friction + lane);
    put(d, pair.at[2], start.restitution + lane);
    const V slop = pair.at[3];
    put(d, difference(a.velocity, b.velocity), start.velocity, lane);
    put(d, a.spin, start.spin_a, lane);
    put(d, b.spin, start.spin_b, lane);
    put(d, Triple<V>{zero, zero, zero}, shared.shift, lane);
    Poses pose_a;
    Poses pose_b;
    read_poses(d, sources.pose_a + lane, pose_a);
    read_poses(d, sources.pose_b + lane, pose_b);
    const Triple<V> a_to_b = difference(pose_b.position, pose_a.position);
    put(d, a_to_b, shared.a_to_b, lane);
    const V per_newton =
        hn::IfThenElseZero(lanes_of(d, sources.warm, lane), hn::Mul(hn::Set(d, sources.substep_s), inverse_mass));
    const ContactPoint* point[kLanes];
    const ContactForce* force[kLanes];
    for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
      point[k] = sources.points[lane + k];
      force[k] = sources.forces[lane + k];
    }
    std::uint32_t present = (1U << hn::Lanes(d)) - 1U;
    for (std::size_t p = 0; p < manifold_points.size(); ++p) {
      PointLanes<T>& into = manifold_points[p];
      for (std::size_t k = 0; k < hn::Lanes(d) && p >= sources.least_points; ++k) {
        if (p < sources.point_count[lane + k]) continue;
        point[k] = none.points.data();
        force[k] = none.forces.data();
        present &= ~(1U << k);
      }
      const auto quad = [&](const auto* of, std::size_t offset) HWY_ATTR {
        return columns_of(d, [&](std::size_t k) { return figures_at<const double>(of[k], p, offset); });
      };
      const Columns<V> on_b = quad(point, 0);
      const Columns<V> on_a = quad(point, 4);
      const Columns<V> load = quad(force, 0);
      const Triple<V> normal = turned(pose_b.rotation, {on_b.at[0], on_b.at[1], on_b.at[2]});
      const Triple<V> arm_a = turned(pose_a.rotation, {on_a.at[0], on_a.at[1], on_a.at[2]});
      const V gap = hn::Add(dot(normal, difference(a_to_b, arm_a)), on_b.at[3]);
      put(d, normal, into.normal, lane);
      put(d, sum(arm_a, scaled(hn::Mul(share, gap), normal)), into.arm, lane);
      put(d, gap, into.gap + lane);
      put(d, hn::Add(hn::Add(gap, on_a.at[3]), slop), into.certain + lane);
      put(d, hn::IfThenElseZero(lanes_of(d, present, 0), one), into.mass + lane);
      put(d, hn::Mul(per_newton, load.at[0]), into.impulse + lane);
      put(d, scaled(per_newton, Triple<V>{load.at[1], load.at[2], load.at[3]}), into.friction_impulse, lane);
    }
  }
}

template <class T>
void collect(const PairLanes<T>& shared, std::span<const PointLanes<T>> manifold_points,
             std::span<const TotalLanes<T>> totals, const LaneForces& forces, LaneImpulses& impulses) {
  const Doubles d;
  const V zero = hn::Zero(d);
  for (std::size_t lane = 0; lane < forces.lanes; lane += hn::Lanes(d)) {
    const V unit_ns = get(d, shared.reduced_mass + lane);
    const V unit_n = hn::Div(unit_ns, hn::Set(d, forces.substep_s));
    Triple<V> impulse = {zero, zero, zero};
    Triple<V> moment = {zero, zero, zero};
    for (std::size_t p = 0; p < manifold_points.size(); ++p) {
      const PointLanes<T>& point = manifold_points[p];
      const Triple<V> friction = scaled(unit_n, get(d, point.friction_impulse, lane));
      std::uint32_t present = 0;
      for (std::size_t k = 0; k < hn::Lanes(d); ++k) present |= (p < forces.point_count[lane + k] ? 1U : 0U) << k;
      store_rows(d, Columns<V>{{hn::Mul(unit_n, get(d, point.impulse + lane)), friction.x, friction.y, friction.z}},
                 present, [&](std::size_t k) { return figures_at<double>(forces.first[lane + k], p, 0); });
      const Triple<V> given = scaled(unit_ns, get(d, totals[p].total, lane));
      impulse = sum(impulse, given);
      moment = sum(moment, cross(get(d, point.arm, lane), given));
    }
    const std::uint32_t all = (1U << hn::Lanes(d)) - 1U;
    store_rows(d, Columns<V>{{impulse.x, impulse.y, impulse.z, zero}}, all,
               [&](std::size_t k) { return impulses.impulse_ns[lane + k]; });
    store_rows(d, Columns<V>{{moment.x, moment.y, moment.z, zero}}, all,
               [&](std::size_t k) { return impulses.moment_a_nms[lane + k]; });
  }
}

void fill_float(const LaneSources& sources, PairLanes<float>& shared, StartLanes<float>& start,
                std::span<PointLanes<float>> manifold_points) {
  fill(sources, shared, start, manifold_points);
}
void fill_double(const LaneSources& sources, PairLanes<double>& shared, StartLanes<double>& start,
                 std::span<PointLanes<double>> manifold_points) {
  fill(sources, shared, start, manifold_points);
}
void collect_float(const PairLanes<float>& shared, std::span<const PointLanes<float>> manifold_points,
                   std::span<const TotalLanes<float>> totals, const LaneForces& forces, LaneImpulses& impulses) {
  collect(shared, manifold_points, totals, forces, impulses);
}
void collect_double(const PairLanes<double>& shared, std::span<const PointLanes<double>> manifold_points,
                    std::span<const TotalLanes<double>> totals, const LaneForces& forces, LaneImpulses& impulses) {
  collect(shared, manifold_points, totals, forces, impulses);
}

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::solver {

HWY_EXPORT(fill_float);
HWY_EXPORT(fill_double);
HWY_EXPORT(collect_float);
HWY_EXPORT(collect_double);

void fill_lanes(const LaneSources& sources, PairLanes<float>& shared, StartLanes<float>& start,
                std::span<PointLanes<float>> manifold_points) {
  HWY_DYNAMIC_DISPATCH(fill_float)(sources, shared, start, manifold_points);
}
void fill_lanes(const LaneSources& sources, PairLanes<double>& shared, StartLanes<double>& start,
                std::span<PointLanes<double>> manifold_points) {
  HWY_DYNAMIC_DISPATCH(fill_double)(sources, shared, start, manifold_points);
}
void collect_lanes(const PairLanes<float>& shared, std::span<const PointLanes<float>> manifold_points,
                   std::span<const TotalLanes<float>> totals, const LaneForces& forces, LaneImpulses& impulses) {
  HWY_DYNAMIC_DISPATCH(collect_float)(shared, manifold_points, totals, forces, impulses);
}
void collect_lanes(const PairLanes<double>& shared, std::span<const PointLanes<double>> manifold_points,
                   std::span<const TotalLanes<double>> totals, const LaneForces& forces, LaneImpulses& impulses) {
  HWY_DYNAMIC_DISPATCH(collect_double)(shared, manifold_points, totals, forces, impulses);
}

}  // namespace poise::solver
#endif
