// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/contacts/contact_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>

#include "solver/contacts/contact_lanes.h"
#include "solver/lane_math_inl.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// One side of some pairs: what the step changes, and how it turns per unit of an impulse's moment.
template <class V>
struct Side {
  Triple<V> v, w, x, q;
  V dynamic;
  V xx, yy, zz, xy, xz, yz;
};

// What is read of the motions of bodies, besides how they turn.
enum class MotionRead { Nothing, Velocities, All };

template <class D, class T>
HWY_INLINE Side<hn::Vec<D>> side(D d, const std::uint32_t* slots, const hn::Vec<D>& dynamic, const BodyLanes<T>& bodies,
                                 MotionRead read) {
  using V = hn::Vec<D>;
  const auto turn = [&](const V& figure) HWY_ATTR { return hn::Mul(dynamic, figure); };
  const Columns<V> first = gather(d, bodies.scaled_inverse_inertias, slots, 0);
  const Columns<V> last = gather(d, bodies.scaled_inverse_inertias, slots, 4);
  const V zero = hn::Zero(d);
  const Triple<V> none = {zero, zero, zero};
  Side<V> made = {none,
                  none,
                  none,
                  none,
                  dynamic,
                  turn(first.at[0]),
                  turn(first.at[1]),
                  turn(first.at[2]),
                  turn(first.at[3]),
                  turn(last.at[0]),
                  turn(last.at[1])};
  if (read == MotionRead::Nothing) return made;
  const Columns<V> one = gather(d, bodies.motions, slots, 0);
  const Columns<V> two = gather(d, bodies.motions, slots, 4);
  made.v = {one.at[0], one.at[1], one.at[2]};
  made.w = {one.at[3], two.at[0], two.at[1]};
  made.x = {two.at[2], two.at[3], zero};
  if (read == MotionRead::Velocities) return made;
  const Columns<V> three = gather(d, bodies.motions, slots, 8);
  made.x.z = three.at[0];
  made.q = {three.at[1], three.at[2], three.at[3]};
  return made;
}

template <class D, class T, class V>
HWY_INLINE void keep(D d, const Side<V>& side, std::uint32_t dynamic, const std::uint32_t* slots, bool pushed,
                     const BodyLanes<T>& bodies) {
  scatter(d, {{side.v.x, side.v.y, side.v.z, side.w.x}}, dynamic, bodies.motions, slots, 0);
  scatter(d, {{side.w.y, side.w.z, side.x.x, side.x.y}}, dynamic, bodies.motions, slots, 4);
  if (pushed) scatter(d, {{side.x.z, side.q.x, side.q.y, side.q.z}}, dynamic, bodies.motions, slots, 8);
}

template <class V>
HWY_INLINE Triple<V> turned(const Side<V>& side, const Triple<V>& t) {
  return {dot(Triple<V>{side.xx, side.xy, side.xz}, t), dot(Triple<V>{side.xy, side.yy, side.yz}, t),
          dot(Triple<V>{side.xz, side.yz, side.zz}, t)};
}

// Some lanes of a block, and one place of each.
template <class V>
struct Pairs {
  Side<V> a, b;
};
template <class V>
struct Arms {
  Triple<V> a, b;
};

// Relative velocity of a against b at a contact point, beyond that at the start of the step.
template <class V>
HWY_INLINE Triple<V> slip(const Pairs<V>& pairs, const Arms<V>& arms) {
  return difference(sum(pairs.a.v, cross(pairs.a.w, arms.a)), sum(pairs.b.v, cross(pairs.b.w, arms.b)));
}
template <class V>
HWY_INLINE Triple<V> way(const Pairs<V>& pairs, const Arms<V>& arms) {
  return difference(sum(pairs.a.x, cross(pairs.a.q, arms.a)), sum(pairs.b.x, cross(pairs.b.q, arms.b)));
}

// Applies an impulse to b and the opposite to a: to velocities, or with kPosition to positions.
template <bool kPosition, class V>
HWY_INLINE void give(const Arms<V>& arms, const Triple<V>& impulse, Pairs<V>& pairs) {
  const Triple<V> ma = scaled(pairs.a.dynamic, impulse);
  const Triple<V> mb = scaled(pairs.b.dynamic, impulse);
  const Triple<V> ta = turned(pairs.a, cross(arms.a, impulse));
  const Triple<V> tb = turned(pairs.b, cross(arms.b, impulse));
  Triple<V>& moving_a = kPosition ? pairs.a.x : pairs.a.v;
  Triple<V>& moving_b = kPosition ? pairs.b.x : pairs.b.v;
  Triple<V>& turning_a = kPosition ? pairs.a.q : pairs.a.w;
  Triple<V>& turning_b = kPosition ? pairs.b.q : pairs.b.w;
  moving_a = difference(moving_a, ma);
  moving_b = sum(moving_b, mb);
  turning_a = difference(turning_a, ta);
  turning_b = sum(turning_b, tb);
}

template <class D, class T>
HWY_INLINE Arms<hn::Vec<D>> arms_of(D d, const PointLanes<T>& point, const Triple<hn::Vec<D>>& a_to_b,
                                    std::size_t lane) {
  // Loaded twice: GCC 12 copies the first in pieces that are larger than what it has just written, which waits.
  return {load(d, point.arm, lane), difference(load(d, point.arm, lane), a_to_b)};
}

// Change of the speed along m by a unit impulse along l: l . K m.
template <class V>
HWY_INLINE V dynamic(const Pairs<V>& pairs, const Triple<V>& ta_l, const Triple<V>& tb_l, const Triple<V>& ta_m,
                     const Triple<V>& tb_m) {
  return hn::Add(dot(ta_l, turned(pairs.a, ta_m)), dot(tb_l, turned(pairs.b, tb_m)));
}

// By how much the mean velocity that some pairs' other bodies need in the step, to stay where kinematic ones carry
// them, differs from that of its start. False where nothing is carried around.
template <class D, class T, class V>
HWY_INLINE bool bend(D d, const Pairs<V>& pairs, const StartLanes<T>& start, std::size_t lane, const V& half_step_s,
                     const Triple<V>& a_to_b, Triple<V>& by) {
  const V zero = hn::Zero(d);
  const auto spin = [&](const V& dynamic, const T(&of)[3][kLanes]) HWY_ATTR {
    const auto carries = hn::Eq(dynamic, zero);
    const Triple<V> all = load(d, of, lane);
    return Triple<V>{hn::IfThenElseZero(carries, all.x), hn::IfThenElseZero(carries, all.y),
                     hn::IfThenElseZero(carries, all.z)};
  };
  const Triple<V> a = spin(pairs.a.dynamic, start.spin_a);
  const Triple<V> b = spin(pairs.b.dynamic, start.spin_b);
  if (hn::AllTrue(d, hn::Eq(hn::Add(dot(a, a), dot(b, b)), zero))) return false;
  by = scaled(half_step_s, sum(cross(a, cross(a, a_to_b)), cross(b, cross(b, a_to_b))));
  return true;
}

template <class T>
void prepare(const ContactBlock& block, const PairLanes<T>& shared, const StartLanes<T>& start, const BlockTerms& terms,
             std::span<PointLanes<T>> manifold_points, const ScaledInverseInertia<T>* scaled_inverse_inertias) {
  const hn::CappedTag<T, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, T(1));
  const V still_mps = hn::Set(d, static_cast<T>(terms.still_mps));
  const V half_step_s = hn::Set(d, static_cast<T>(0.5 * terms.step_s));
  const BodyLanes<T> bodies = {nullptr, scaled_inverse_inertias};
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
    const Pairs<V> pairs = {side(d, block.a + lane, hn::Load(d, shared.dynamic_a + lane), bodies, MotionRead::Nothing),
                            side(d, block.b + lane, hn::Load(d, shared.dynamic_b + lane), bodies, MotionRead::Nothing)};
    const Triple<V> a_to_b = load(d, shared.a_to_b, lane);
    const V reduced_mass = hn::Load(d, shared.reduced_mass + lane);
    const V moving = hn::Add(pairs.a.dynamic, pairs.b.dynamic);
    Triple<V> bent;
    const bool bends = bend(d, pairs, start, lane, half_step_s, a_to_b, bent);
    for (PointLanes<T>& point : manifold_points) {
      const Triple<V> n = load(d, point.normal, lane);
      const Arms<V> arms = arms_of(d, point, a_to_b, lane);
      Triple<V> rate = sum(load(d, start.velocity, lane), difference(cross(load(d, start.spin_a, lane), arms.a),
                                                                     cross(load(d, start.spin_b, lane), arms.b)));
      // Along the surface: along the normal that of what is round does not go with it.
      if (bends) rate = sum(rate, difference(bent, scaled(dot(bent, n), n)));
      const Triple<V> ta = cross(arms.a, n);
      const Triple<V> tb = cross(arms.b, n);
      const V k = hn::Add(moving, dynamic(pairs, ta, tb, ta, tb));
      // The inverse masses make a sum of 1, so 1 / M is at least that.
      auto counts = hn::And(hn::Gt(reduced_mass, zero), hn::Ge(k, hn::Set(d, T(0.5))));
      counts = hn::And(counts, hn::Gt(hn::Load(d, point.mass + lane), zero));
      counts = hn::And(counts, hn::Le(hn::Mul(hn::Load(d, start.restitution + lane), dot(n, rate)), still_mps));
      store(d, rate, point.rate, lane);
      hn::Store(hn::IfThenElseZero(counts, hn::Div(one, hn::IfThenElse(counts, k, one))), d, point.mass + lane);
      hn::Store(hn::IfThenElseZero(counts, hn::Load(d, point.impulse + lane)), d, point.impulse + lane);
      const auto frictional = hn::And(counts, hn::Gt(hn::Load(d, shared.friction + lane), zero));
      if (!block.frictional || hn::AllFalse(d, frictional)) {
        hn::Store(zero, d, point.across + lane);
        store(d, Triple<V>{zero, zero, zero}, point.friction_impulse, lane);
        continue;
      }
      const V sign = hn::CopySign(one, n.z);
      const V p = hn::Neg(hn::Div(one, hn::IfThenElse(counts, hn::Add(sign, n.z), one)));
      const V q = hn::Mul(hn::Mul(n.x, n.y), p);
      const Triple<V> first = {hn::Add(one, hn::Mul(hn::Mul(sign, hn::Mul(n.x, n.x)), p)), hn::Mul(sign, q),
                               hn::Neg(hn::Mul(sign, n.x))};
      const Triple<V> second = {q, hn::Add(sign, hn::Mul(hn::Mul(n.y, n.y), p)), hn::Neg(n.y)};
      const Triple<V> ta1 = cross(arms.a, first);
      const Triple<V> tb1 = cross(arms.b, first);
      const Triple<V> ta2 = cross(arms.a, second);
      const Triple<V> tb2 = cross(arms.b, second);
      const V k1 = hn::Add(moving, dynamic(pairs, ta1, tb1, ta1, tb1));
      const V k2 = hn::Add(moving, dynamic(pairs, ta2, tb2, ta2, tb2));
      const V mixed = dynamic(pairs, ta1, tb1, ta2, tb2);
      const V half = hn::Set(d, T(0.5));
      const V apart = hn::Mul(half, hn::Sub(k1, k2));
      // Both tangents use the smallest effective mass of the two, so friction opposes the slip and never overshoots.
      const V most =
          hn::Add(hn::Mul(half, hn::Add(k1, k2)), hn::Sqrt(hn::Add(hn::Mul(apart, apart), hn::Mul(mixed, mixed))));
      hn::Store(hn::IfThenElseZero(frictional, hn::Div(one, hn::IfThenElse(frictional, most, one))), d,
                point.across + lane);
      // Projects the accumulated friction into the current tangent plane.
      const Triple<V> friction_impulse = load(d, point.friction_impulse, lane);
      const Triple<V> across = difference(friction_impulse, scaled(dot(friction_impulse, n), n));
      store(d,
            Triple<V>{hn::IfThenElseZero(frictional, across.x), hn::IfThenElseZero(frictional, across.y),
                      hn::IfThenElseZero(frictional, across.z)},
            point.friction_impulse, lane);
    }
  }
}

template <class D, class T>
HWY_INLINE Pairs<hn::Vec<D>> pairs_at(D d, const ContactBlock& block, const PairLanes<T>& shared, std::size_t lane,
                                      const BodyLanes<T>& bodies, MotionRead read) {
  return {side(d, block.a + lane, hn::Load(d, shared.dynamic_a + lane), bodies, read),
          side(d, block.b + lane, hn::Load(d, shared.dynamic_b + lane), bodies, read)};
}
template <class D, class T, class V>
HWY_INLINE void keep_pairs(D d, const Pairs<V>& pairs, const ContactBlock& block, std::size_t lane, bool pushed,
                           const BodyLanes<T>& bodies) {
  keep(d, pairs.a, std::uint32_t{block.dynamic_a} >> lane, block.a + lane, pushed, bodies);
  keep(d, pairs.b, std::uint32_t{block.dynamic_b} >> lane, block.b + lane, pushed, bodies);
}

template <class T>
void warm(const ContactBlock& block, const PairLanes<T>& shared, std::span<const PointLanes<T>> manifold_points,
          const BodyLanes<T>& bodies) {
  const hn::CappedTag<T, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  for (std::size_t lane = 0; lane < block.count; lane += hn::Lanes(d)) {
    Pairs<V> pairs = pairs_at(d, block, shared, lane, bodies, MotionRead::Velocities);
    const Triple<V> a_to_b = load(d, shared.a_to_b, lane);
    for (const PointLanes<T>& point : manifold_points) {
      const Triple<V> along = scaled(hn::Load(d, point.impulse + lane), load(d, point.normal, lane));
      give<false>(arms_of(d, point, a_to_b, lane),
                  block.frictional ? sum(along, load(d, point.friction_impulse, lane)) : along, pairs);
    }
    keep_pairs(d, pairs, block, lane, false, bodies);
  }
}

// What an iteration changes, in some lanes of a block.
template <class V>
struct LaneChange {
  V largest_ns, change_ns, change_mps, impulse_sum_ns, residual_j;
};

// Notes the impulse of a contact point, and by how much it changed, both divided by the reduced mass.
template <class D, class V>
HWY_INLINE void note(D d, const V& mass, const V& reduced_mass, const V& impulse, const V& change,
                     LaneChange<V>& changed) {
  const auto counts = hn::Gt(mass, hn::Zero(d));
  const V change_mps =
      hn::IfThenElseZero(counts, hn::Div(change, hn::IfThenElse(counts, mass, hn::Set(d, hn::TFromD<D>(1)))));
  const V impulse_ns = hn::Mul(reduced_mass, impulse);
  changed.change_mps = hn::Max(change_mps, changed.change_mps);
  changed.change_ns = hn::Max(hn::Mul(reduced_mass, change), changed.change_ns);
  changed.largest_ns = hn::Max(impulse_ns, changed.largest_ns);
  changed.impulse_sum_ns = hn::Add(changed.impulse_sum_ns, impulse_ns);
  changed.residual_j = hn::Add(changed.residual_j, hn::Mul(impulse_ns, change_mps));
}

// Adds what some lanes changed to what is known of a block: sums lane after lane, however many there are at once.
template <class D, class V, class T>
HWY_INLINE void add_change(D d, const LaneChange<V>& lanes, IterationChange<T>& changed) {
  const auto largest = [&](const V& of) HWY_ATTR { return hn::GetLane(hn::MaxOfLanes(d, of)); };
  changed.largest_ns = std::max(changed.largest_ns, largest(lanes.largest_ns));
  changed.change_ns = std::max(changed.change_ns, largest(lanes.change_ns));
  changed.change_mps = std::max(changed.change_mps, largest(lanes.change_mps));
  alignas(64) T impulses[kLanes];
  alignas(64) T residuals[kLanes];
  hn::Store(lanes.impulse_sum_ns, d, impulses);
  hn::Store(lanes.residual_j, d, residuals);
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    changed.impulse_sum_ns += impulses[k];
    changed.residual_j += residuals[k];
  }
}

// Friction at one contact point, clamped to the cone of the impulse along the normal; the size of what changed.
template <class D, class T, class V>
HWY_INLINE V apply_friction(D d, PointLanes<T>& point, const V& friction, const Triple<V>& n, const Triple<V>& rate,
                            const Arms<V>& arms, const V& impulse, std::size_t lane, Pairs<V>& pairs,
                            const V& relaxation) {
  const V one = hn::Set(d, T(1));
  const V across = hn::Mul(relaxation, hn::Load(d, point.across + lane));
  const Triple<V> before = load(d, point.friction_impulse, lane);
  const Triple<V> velocity = sum(rate, slip(pairs, arms));
  const Triple<V> sliding = difference(velocity, scaled(dot(velocity, n), n));
  const Triple<V> wanted = sum(before, scaled(across, sliding));
  const V most = hn::IfThenElseZero(hn::Gt(across, hn::Zero(d)), hn::Mul(friction, impulse));
  const V size = hn::Sqrt(dot(wanted, wanted));
  const auto beyond = hn::Gt(size, most);
  const V scale = hn::IfThenElse(beyond, hn::Div(most, hn::IfThenElse(beyond, size, one)), one);
  const Triple<V> after = scaled(scale, wanted);
  const Triple<V> given = difference(after, before);
  store(d, after, point.friction_impulse, lane);
  give<false>(arms, given, pairs);
  return hn::Sqrt(dot(given, given));
}

// Adds the impulse of a contact point to its total.
template <class D, class T, class V>
HWY_INLINE void add_impulse(D d, const PointLanes<T>& point, const Triple<V>& n, const V& impulse, bool frictional,
                            std::size_t lane, TotalLanes<T>& into) {
  Triple<V> total = sum(load(d, into.total, lane), scaled(impulse, n));
  if (frictional) total = sum(total, load(d, point.friction_impulse, lane));
  store(d, total, into.total, lane);
}

// The total before what the substep ends with is added.
template <class D, class T, class V>
HWY_INLINE void begin_total(D d, const PointLanes<T>& point, const Triple<V>& n, const V& before, bool frictional,
                            const SubstepTotals& of, std::size_t lane, TotalLanes<T>& into) {
  const V zero = hn::Zero(d);
  if (!of.carried) store(d, Triple<V>{zero, zero, zero}, into.total, lane);
  if (of.before) add_impulse(d, point, n, before, frictional, lane, into);
}

template <class T>
IterationChange<T> solve(ContactBlock& block, const SolvedLanes<T>& lanes, const SubstepTerms<T>& terms,
                         std::uint32_t iteration, const BodyLanes<T>& bodies) {
  const hn::CappedTag<T, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  const V zero = hn::Zero(d);
  const V per_h = hn::Set(d, T(1) / terms.h_s);
  const V relaxation = hn::Set(d, terms.relaxation);
  // Positions change in the first iteration alone.
  const bool push = iteration == 0;
  const bool moved = iteration <= 1;
  PairLanes<T>& shared = lanes.pairs;
  const std::span<TotalLanes<T>> totals = lanes.totals;
  IterationChange<T> changed;
  for (std::size_t lane = 0; lane < block.count; lane += hn::Lanes(d)) {
    Pairs<V> pairs = pairs_at(d, block, shared, lane, bodies, moved ? MotionRead::All : MotionRead::Velocities);
    const Triple<V> a_to_b = load(d, shared.a_to_b, lane);
    const V friction = hn::Load(d, shared.friction + lane);
    bool any_pushed = false;
    LaneChange<V> here = {zero, zero, zero, zero, zero};
    for (std::size_t p = 0; p < lanes.manifold_points.size(); ++p) {
      PointLanes<T>& point = lanes.manifold_points[p];
      const auto load_at = [&](const T* from) HWY_ATTR { return hn::Load(d, from + lane); };
      const Triple<V> n = load(d, point.normal, lane);
      const Triple<V> rate = load(d, point.rate, lane);
      const Arms<V> arms = arms_of(d, point, a_to_b, lane);
      const V mass = load_at(point.mass);
      V closed = zero;
      if (moved) {
        closed = dot(n, sum(scaled(hn::Set(d, terms.begun_s), rate), way(pairs, arms)));
        hn::Store(hn::Max(hn::Sub(load_at(point.gap), closed), zero), d, point.left + lane);
      }
      const V gap = load_at(point.left);
      const V closing = dot(n, sum(rate, slip(pairs, arms)));
      const V before = load_at(point.impulse);
      if (!terms.watch && terms.totals.after) {
        begin_total(d, point, n, before, block.frictional, terms.totals, lane, totals[p]);
      }
      V after =
          hn::Max(hn::Add(before, hn::Mul(hn::Mul(relaxation, mass), hn::Sub(closing, hn::Mul(gap, per_h)))), zero);
      after = hn::IfThenElseZero(hn::Gt(mass, zero), after);
      hn::Store(after, d, point.impulse + lane);
      const V units = hn::Sub(after, before);
      give<false>(arms, scaled(units, n), pairs);
      V change = hn::Abs(units);
      if (block.frictional)
        change = hn::Max(change, apply_friction(d, point, friction, n, rate, arms, after, lane, pairs, relaxation));
      if (terms.watch) {
        note(d, mass, load_at(shared.reduced_mass), after, change, here);
      } else if (terms.totals.after) {
        add_impulse(d, point, n, after, block.frictional, lane, totals[p]);
      }
      if (!push) continue;
      const V overlap = hn::Sub(closed, load_at(point.certain));
      // A pair that separates by itself needs no correction.
      const auto may =
          hn::And(hn::And(hn::Gt(overlap, zero), hn::Gt(mass, zero)), hn::Gt(closing, hn::Set(d, -terms.still_mps)));
      if (hn::AllFalse(d, may)) continue;
      const V length = hn::Min(hn::Mul(overlap, hn::Set(d, terms.push_share)), hn::Set(d, terms.most_push_m));
      const Triple<V> moves = scaled(hn::IfThenElseZero(may, hn::Mul(mass, length)), n);
      give<true>(arms, moves, pairs);
      store(d, sum(load(d, shared.shift, lane), moves), shared.shift, lane);
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, may, bits);
      block.pushed = static_cast<std::uint8_t>(block.pushed | (bits[0] << lane));
      any_pushed = true;
    }
    keep_pairs(d, pairs, block, lane, any_pushed, bodies);
    if (terms.watch) add_change(d, here, changed);
  }
  return changed;
}

void prepare_float(const ContactBlock& block, const PairLanes<float>& pairs, const StartLanes<float>& start,
                   const BlockTerms& terms, std::span<PointLanes<float>> manifold_points,
                   const ScaledInverseInertia<float>* scaled_inverse_inertias) {
  prepare(block, pairs, start, terms, manifold_points, scaled_inverse_inertias);
}
void prepare_double(const ContactBlock& block, const PairLanes<double>& pairs, const StartLanes<double>& start,
                    const BlockTerms& terms, std::span<PointLanes<double>> manifold_points,
                    const ScaledInverseInertia<double>* scaled_inverse_inertias) {
  prepare(block, pairs, start, terms, manifold_points, scaled_inverse_inertias);
}
void warm_float(const ContactBlock& block, const PairLanes<float>& pairs,
                std::span<const PointLanes<float>> manifold_points, const BodyLanes<float>& bodies) {
  warm(block, pairs, manifold_points, bodies);
}
void warm_double(const ContactBlock& block, const PairLanes<double>& pairs,
                 std::span<const PointLanes<double>> manifold_points, const BodyLanes<double>& bodies) {
  warm(block, pairs, manifold_points, bodies);
}
IterationChange<float> solve_float(ContactBlock& block, const SolvedLanes<float>& lanes,
                                   const SubstepTerms<float>& terms, std::uint32_t iteration,
                                   const BodyLanes<float>& bodies) {
  return solve(block, lanes, terms, iteration, bodies);
}
IterationChange<double> solve_double(ContactBlock& block, const SolvedLanes<double>& lanes,
                                     const SubstepTerms<double>& terms, std::uint32_t iteration,
                                     const BodyLanes<double>& bodies) {
  return solve(block, lanes, terms, iteration, bodies);
}

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::solver {

HWY_EXPORT(prepare_float);
HWY_EXPORT(prepare_double);
HWY_EXPORT(warm_float);
HWY_EXPORT(warm_double);
HWY_EXPORT(solve_float);
HWY_EXPORT(solve_double);

void prepare_block(const ContactBlock& block, const PairLanes<float>& pairs, const StartLanes<float>& start,
                   const BlockTerms& terms, std::span<PointLanes<float>> manifold_points,
                   const ScaledInverseInertia<float>* scaled_inverse_inertias) {
  HWY_DYNAMIC_DISPATCH(prepare_float)(block, pairs, start, terms, manifold_points, scaled_inverse_inertias);
}
void prepare_block(const ContactBlock& block, const PairLanes<double>& pairs, const StartLanes<double>& start,
                   const BlockTerms& terms, std::span<PointLanes<double>> manifold_points,
                   const ScaledInverseInertia<double>* scaled_inverse_inertias) {
  HWY_DYNAMIC_DISPATCH(prepare_double)(block, pairs, start, terms, manifold_points, scaled_inverse_inertias);
}
void warm_start_block(const ContactBlock& block, const PairLanes<float>& pairs,
                      std::span<const PointLanes<float>> manifold_points, const BodyLanes<float>& bodies) {
  HWY_DYNAMIC_DISPATCH(warm_float)(block, pairs, manifold_points, bodies);
}
void warm_start_block(const ContactBlock& block, const PairLanes<double>& pairs,
                      std::span<const PointLanes<double>> manifold_points, const BodyLanes<double>& bodies) {
  HWY_DYNAMIC_DISPATCH(warm_double)(block, pairs, manifold_points, bodies);
}
IterationChange<float> solve_block(ContactBlock& block, const SolvedLanes<float>& lanes,
                                   const SubstepTerms<float>& terms, std::uint32_t iteration,
                                   const BodyLanes<float>& bodies) {
  return HWY_DYNAMIC_DISPATCH(solve_float)(block, lanes, terms, iteration, bodies);
}
IterationChange<double> solve_block(ContactBlock& block, const SolvedLanes<double>& lanes,
                                    const SubstepTerms<double>& terms, std::uint32_t iteration,
                                    const BodyLanes<double>& bodies) {
  return HWY_DYNAMIC_DISPATCH(solve_double)(block, lanes, terms, iteration, bodies);
}

}  // namespace poise::solver
#endif
