// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "response/rest_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>

#include "response/rest_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace poise::response::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Multiplications and additions stay apart: fused ones would round differently from one instruction set to the next.

// The motions of eight bodies, a figure an array: v, w, x, q.
template <class T>
struct Gathered {
  alignas(64) T at[12][kLanes];
};

template <class T>
HWY_INLINE void gather(const std::uint32_t (&bodies)[kLanes], const Motion<T>* motions, Gathered<T>& into) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const T* const from = motions[bodies[lane]].v;
    for (std::size_t k = 0; k < 12; ++k) into.at[k][lane] = from[k];
  }
}

template <class T>
HWY_INLINE void scatter(const std::uint32_t (&bodies)[kLanes], std::uint8_t yields, std::size_t figures, const Gathered<T>& from, Motion<T>* motions) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if ((std::uint32_t{yields} >> lane & 1U) == 0) continue;
    T* const to = motions[bodies[lane]].v;
    for (std::size_t k = 0; k < figures; ++k) to[k] = from.at[k][lane];
  }
}

// Three numbers in each lane.
template <class V>
struct Triple {
  V x, y, z;
};

template <class D, class T>
HWY_INLINE Triple<hn::Vec<D>> load(D d, const T (*from)[kLanes], std::size_t lane) {
  return {hn::Load(d, from[0] + lane), hn::Load(d, from[1] + lane), hn::Load(d, from[2] + lane)};
}
template <class D, class V, class T>
HWY_INLINE void store(D d, const Triple<V>& value, T (*to)[kLanes], std::size_t lane) {
  hn::Store(value.x, d, to[0] + lane);
  hn::Store(value.y, d, to[1] + lane);
  hn::Store(value.z, d, to[2] + lane);
}
template <class V>
HWY_INLINE V dot(const Triple<V>& a, const Triple<V>& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class V>
HWY_INLINE Triple<V> plus(const Triple<V>& a, const V& scale, const Triple<V>& b) {
  return {hn::Add(a.x, hn::Mul(scale, b.x)), hn::Add(a.y, hn::Mul(scale, b.y)), hn::Add(a.z, hn::Mul(scale, b.z))};
}
template <class V>
HWY_INLINE Triple<V> minus(const Triple<V>& a, const V& scale, const Triple<V>& b) {
  return {hn::Sub(a.x, hn::Mul(scale, b.x)), hn::Sub(a.y, hn::Mul(scale, b.y)), hn::Sub(a.z, hn::Mul(scale, b.z))};
}

// Some lanes of a pair of bodies. Moving and turning are rates, or what these add up to.
template <class V>
struct Pairs {
  Triple<V> moving_a, turning_a, moving_b, turning_b;
};

// By how much the bodies approach each other along a direction.
template <class D, class T, class V>
HWY_INLINE V approach(D d, const DirectionLanes<T>& of, std::size_t lane, const Pairs<V>& pairs) {
  const auto l = load(d, of.l, lane);
  const V a = hn::Add(dot(l, pairs.moving_a), dot(load(d, of.ta, lane), pairs.turning_a));
  const V b = hn::Add(dot(l, pairs.moving_b), dot(load(d, of.tb, lane), pairs.turning_b));
  return hn::Sub(a, b);
}

// Gives b so many units along a direction and a the opposite.
template <class D, class T, class V>
HWY_INLINE void give(D d, const DirectionLanes<T>& of, std::size_t lane, const V& units, Pairs<V>& pairs) {
  const auto l = load(d, of.l, lane);
  pairs.moving_a = minus(pairs.moving_a, hn::Mul(units, hn::Load(d, of.ma + lane)), l);
  pairs.moving_b = plus(pairs.moving_b, hn::Mul(units, hn::Load(d, of.mb + lane)), l);
  pairs.turning_a = minus(pairs.turning_a, units, load(d, of.ua, lane));
  pairs.turning_b = plus(pairs.turning_b, units, load(d, of.ub, lane));
}

template <class D, class T>
HWY_INLINE Pairs<hn::Vec<D>> pairs_at(D d, const Gathered<T>& a, const Gathered<T>& b, std::size_t first, std::size_t lane) {
  return {load(d, a.at + first, lane), load(d, a.at + first + 3, lane), load(d, b.at + first, lane), load(d, b.at + first + 3, lane)};
}
template <class D, class T, class V>
HWY_INLINE void keep(D d, const Pairs<V>& pairs, std::size_t first, std::size_t lane, Gathered<T>& a, Gathered<T>& b) {
  store(d, pairs.moving_a, a.at + first, lane);
  store(d, pairs.turning_a, a.at + first + 3, lane);
  store(d, pairs.moving_b, b.at + first, lane);
  store(d, pairs.turning_b, b.at + first + 3, lane);
}

template <class V>
HWY_INLINE Triple<V> cross(const Triple<V>& a, const Triple<V>& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
template <class V>
HWY_INLINE Triple<V> scaled(const V& by, const Triple<V>& a) {
  return {hn::Mul(by, a.x), hn::Mul(by, a.y), hn::Mul(by, a.z)};
}

template <class D, class T>
HWY_INLINE Triple<hn::Vec<D>> turned(D d, const SideLanes<T>& side, std::size_t lane, const Triple<hn::Vec<D>>& t) {
  const auto at = [&](std::size_t k) HWY_ATTR { return hn::Load(d, side.inertia[k] + lane); };
  return {dot(Triple<hn::Vec<D>>{at(0), at(3), at(4)}, t), dot(Triple<hn::Vec<D>>{at(3), at(1), at(5)}, t),
          dot(Triple<hn::Vec<D>>{at(4), at(5), at(2)}, t)};
}

// A direction at the places of some lanes: moments, what it turns, and 1 / M.
template <class V>
struct Along {
  Triple<V> l, ta, tb, ua, ub;
  V k;
};

template <class D, class T, class V>
HWY_INLINE Along<V> along(D d, const PairLanes<T>& pairs, std::size_t lane, const Triple<V>& l, const Triple<V>& arm_a, const Triple<V>& arm_b) {
  Along<V> made;
  made.l = l;
  made.ta = cross(arm_a, l);
  made.tb = cross(arm_b, l);
  made.ua = turned(d, pairs.a, lane, made.ta);
  made.ub = turned(d, pairs.b, lane, made.tb);
  made.k = hn::Add(hn::Add(hn::Load(d, pairs.a.yield + lane), hn::Load(d, pairs.b.yield + lane)), hn::Add(dot(made.ta, made.ua), dot(made.tb, made.ub)));
  return made;
}

template <class D, class T, class V>
HWY_INLINE V rate_of(D d, const PairLanes<T>& pairs, std::size_t lane, const Along<V>& made) {
  return hn::Sub(hn::Add(dot(made.l, load(d, pairs.velocity, lane)), dot(made.ta, load(d, pairs.a.spin, lane))), dot(made.tb, load(d, pairs.b.spin, lane)));
}

template <class D, class T, class V>
HWY_INLINE void keep_direction(D d, const PairLanes<T>& pairs, std::size_t lane, const Along<V>& made, const V& mass, const V& rate,
                               DirectionLanes<T>& into) {
  store(d, made.l, into.l, lane);
  store(d, made.ta, into.ta, lane);
  store(d, made.tb, into.tb, lane);
  store(d, scaled(mass, made.ua), into.ua, lane);
  store(d, scaled(mass, made.ub), into.ub, lane);
  hn::Store(hn::Mul(mass, hn::Load(d, pairs.a.yield + lane)), d, into.ma + lane);
  hn::Store(hn::Mul(mass, hn::Load(d, pairs.b.yield + lane)), d, into.mb + lane);
  hn::Store(rate, d, into.rate + lane);
}

template <class T>
void prepare(const PairLanes<T>& pairs, const PlaceLanes<T>& places, T still_mps, PatchLanes<T>& patch, FrictionLanes<T>* friction) {
  const hn::CappedTag<T, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, T(1));
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
    const Triple<V> n = load(d, places.normal, lane);
    const Triple<V> arm_a = load(d, places.arm, lane);
    const Triple<V> arm_b = minus(arm_a, one, load(d, pairs.a_to_b, lane));
    const V newton_s = hn::Load(d, pairs.newton_s + lane);
    const Along<V> normal = along(d, pairs, lane, n, arm_a, arm_b);
    const V rate = rate_of(d, pairs, lane, normal);
    // The inverse masses make a sum of 1, so 1 / M is at least that.
    auto counts = hn::And(hn::Gt(newton_s, zero), hn::Ge(normal.k, hn::Set(d, T(0.5))));
    counts = hn::And(counts, hn::Le(hn::Mul(hn::Load(d, pairs.restitution + lane), rate), hn::Set(d, still_mps)));
    const V mass = hn::IfThenElseZero(counts, hn::Div(one, hn::IfThenElse(counts, normal.k, one)));
    keep_direction(d, pairs, lane, normal, mass, rate, patch.normal);
    hn::Store(hn::Mul(mass, newton_s), d, patch.newton_s + lane);
    hn::Store(hn::IfThenElseZero(counts, hn::Mul(hn::Load(d, places.impulse + lane), normal.k)), d, patch.impulse + lane);
    hn::Store(zero, d, patch.total + lane);
    if (friction == nullptr) continue;
    const V sign = hn::CopySign(one, n.z);
    const V p = hn::Neg(hn::Div(one, hn::IfThenElse(counts, hn::Add(sign, n.z), one)));
    const V q = hn::Mul(hn::Mul(n.x, n.y), p);
    const Triple<V> tangents[2] = {
        {hn::Add(one, hn::Mul(hn::Mul(sign, hn::Mul(n.x, n.x)), p)), hn::Mul(sign, q), hn::Neg(hn::Mul(sign, n.x))},
        {q, hn::Add(sign, hn::Mul(hn::Mul(n.y, n.y), p)), hn::Neg(n.y)}};
    const Along<V> first = along(d, pairs, lane, tangents[0], arm_a, arm_b);
    const Along<V> second = along(d, pairs, lane, tangents[1], arm_a, arm_b);
    const V mixed = hn::Add(dot(first.ta, second.ua), dot(first.tb, second.ub));
    const V half = hn::Set(d, T(0.5));
    const V middle = hn::Mul(half, hn::Add(first.k, second.k));
    const V apart = hn::Mul(half, hn::Sub(first.k, second.k));
    // Both count with one mass, that of the direction which yields most: so friction points against the slip and never overshoots.
    const V most = hn::Add(middle, hn::Sqrt(hn::Add(hn::Mul(apart, apart), hn::Mul(mixed, mixed))));
    const V coefficient = hn::Load(d, pairs.friction + lane);
    const auto rubs = hn::And(counts, hn::Gt(coefficient, zero));
    const V across = hn::IfThenElseZero(rubs, hn::Div(one, hn::IfThenElse(rubs, most, one)));
    const Triple<V> rubbed = load(d, places.rubbed, lane);
    const Along<V>* const both[2] = {&first, &second};
    for (std::size_t t = 0; t < 2; ++t) {
      keep_direction(d, pairs, lane, *both[t], across, rate_of(d, pairs, lane, *both[t]), friction->along[t]);
      hn::Store(hn::IfThenElseZero(rubs, hn::Mul(dot(rubbed, both[t]->l), most)), d, friction->impulse[t] + lane);
      hn::Store(zero, d, friction->total[t] + lane);
    }
    hn::Store(hn::Mul(across, hn::IfThenElseZero(counts, normal.k)), d, friction->share + lane);
    hn::Store(hn::IfThenElseZero(rubs, coefficient), d, friction->coefficient + lane);
  }
}

template <class T>
void warm(RestBlock& block, const PatchLanes<T>* patches, const FrictionLanes<T>* friction, Motion<T>* motions) {
  const hn::CappedTag<T, kLanes> d;
  Gathered<T> a;
  Gathered<T> b;
  gather(block.a, motions, a);
  gather(block.b, motions, b);
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
    auto pairs = pairs_at(d, a, b, 0, lane);
    for (std::size_t p = 0; p < block.patches; ++p) {
      give(d, patches[p].normal, lane, hn::Load(d, patches[p].impulse + lane), pairs);
      if (friction == nullptr) continue;
      for (std::size_t t = 0; t < 2; ++t) give(d, friction[p].along[t], lane, hn::Load(d, friction[p].impulse[t] + lane), pairs);
    }
    keep(d, pairs, 0, lane, a, b);
  }
  scatter(block.a, block.yields_a, 6, a, motions);
  scatter(block.b, block.yields_b, 6, b, motions);
}

// The larger of what was and the largest of the lanes.
template <class D, class V, class T>
HWY_INLINE void note(D d, const V& value, T& largest) {
  alignas(64) T lanes[kLanes];
  hn::Store(value, d, lanes);
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) largest = std::max(largest, lanes[k]);
}

// Friction at one patch, clamped to the cone of the impulse along the normal; the largest change, in units along the normal.
template <class D, class T, class V>
HWY_INLINE V rub(D d, const PatchLanes<T>& patch, FrictionLanes<T>& friction, std::size_t lane, Pairs<V>& moving) {
  const auto load_at = [&](const T* from) HWY_ATTR { return hn::Load(d, from + lane); };
  V wanted[2];
  V square = hn::Zero(d);
  for (std::size_t t = 0; t < 2; ++t) {
    const V slip = hn::Add(load_at(friction.along[t].rate), approach(d, friction.along[t], lane, moving));
    wanted[t] = hn::Add(load_at(friction.impulse[t]), slip);
    const V newtons = hn::Mul(wanted[t], load_at(friction.share));
    square = hn::Add(square, hn::Mul(newtons, newtons));
  }
  const V most = hn::Mul(load_at(friction.coefficient), load_at(patch.impulse));
  const V size = hn::Sqrt(square);
  const auto beyond = hn::Gt(size, most);
  const V scale = hn::IfThenElse(beyond, hn::Div(most, hn::IfThenElse(beyond, size, hn::Set(d, T(1)))), hn::Set(d, T(1)));
  V change = hn::Zero(d);
  for (std::size_t t = 0; t < 2; ++t) {
    const V kept = hn::Mul(wanted[t], scale);
    const V units = hn::Sub(kept, load_at(friction.impulse[t]));
    hn::Store(kept, d, friction.impulse[t] + lane);
    give(d, friction.along[t], lane, units, moving);
    change = hn::Max(change, hn::Abs(hn::Mul(units, load_at(friction.share))));
  }
  return change;
}

template <class T>
SweepChange<T> solve(RestBlock& block, PatchLanes<T>* patches, FrictionLanes<T>* friction, const SubstepTerms<T>& terms, bool push,
                     Motion<T>* motions) {
  const hn::CappedTag<T, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  Gathered<T> a;
  Gathered<T> b;
  gather(block.a, motions, a);
  gather(block.b, motions, b);
  const V zero = hn::Zero(d);
  const V per_h = hn::Set(d, T(1) / terms.h_s);
  SweepChange<T> changed;
  bool any_pushed = false;
  for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
    Pairs<V> moving = pairs_at(d, a, b, 0, lane);
    Pairs<V> moved = pairs_at(d, a, b, 6, lane);
    for (std::size_t p = 0; p < block.patches; ++p) {
      PatchLanes<T>& patch = patches[p];
      const auto load_at = [&](const T* from) HWY_ATTR { return hn::Load(d, from + lane); };
      const V rate = load_at(patch.normal.rate);
      const V unit = load_at(patch.newton_s);
      const V closed = hn::Add(hn::Mul(rate, hn::Set(d, terms.begun_s)), approach(d, patch.normal, lane, moved));
      const V gap = hn::Max(hn::Sub(load_at(patch.gap), closed), zero);
      const V closing = hn::Add(rate, approach(d, patch.normal, lane, moving));
      const V before = load_at(patch.impulse);
      V after = hn::Max(hn::Add(before, hn::Sub(closing, hn::Mul(gap, per_h))), zero);
      after = hn::IfThenElseZero(hn::Gt(unit, zero), after);
      hn::Store(after, d, patch.impulse + lane);
      const V units = hn::Sub(after, before);
      give(d, patch.normal, lane, units, moving);
      V change = zero;
      if (friction != nullptr) change = rub(d, patch, friction[p], lane, moving);
      if (terms.watch) {
        change = hn::Max(change, hn::Abs(units));
        note(d, change, changed.change_mps);
        note(d, hn::Mul(unit, change), changed.change_ns);
        note(d, hn::Mul(unit, after), changed.largest_ns);
      }
      if (!push) continue;
      const V overlap = hn::Sub(closed, load_at(patch.surely));
      // A pair that parts by itself need not be pushed.
      const auto may = hn::And(hn::And(hn::Gt(overlap, zero), hn::Gt(unit, zero)), hn::Gt(closing, hn::Set(d, -terms.still_mps)));
      if (hn::AllFalse(d, may)) continue;
      const V length = hn::Min(hn::Mul(overlap, hn::Set(d, terms.push_share)), hn::Set(d, terms.most_push_m));
      give(d, patch.normal, lane, hn::IfThenElseZero(may, length), moved);
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, may, bits);
      block.pushed = static_cast<std::uint8_t>(block.pushed | (bits[0] << lane));
      any_pushed = true;
    }
    keep(d, moving, 0, lane, a, b);
    keep(d, moved, 6, lane, a, b);
  }
  const std::size_t figures = any_pushed ? 12 : 6;
  scatter(block.a, block.yields_a, figures, a, motions);
  scatter(block.b, block.yields_b, figures, b, motions);
  return changed;
}

void prepare_float(const PairLanes<float>& pairs, const PlaceLanes<float>& places, float still_mps, PatchLanes<float>& patch, FrictionLanes<float>* friction) {
  prepare(pairs, places, still_mps, patch, friction);
}
void prepare_double(const PairLanes<double>& pairs, const PlaceLanes<double>& places, double still_mps, PatchLanes<double>& patch,
                    FrictionLanes<double>* friction) {
  prepare(pairs, places, still_mps, patch, friction);
}
void warm_float(RestBlock& block, const PatchLanes<float>* patches, const FrictionLanes<float>* friction, Motion<float>* motions) {
  warm(block, patches, friction, motions);
}
void warm_double(RestBlock& block, const PatchLanes<double>* patches, const FrictionLanes<double>* friction, Motion<double>* motions) {
  warm(block, patches, friction, motions);
}
SweepChange<float> solve_float(RestBlock& block, PatchLanes<float>* patches, FrictionLanes<float>* friction, const SubstepTerms<float>& terms,
                               bool push, Motion<float>* motions) {
  return solve(block, patches, friction, terms, push, motions);
}
SweepChange<double> solve_double(RestBlock& block, PatchLanes<double>* patches, FrictionLanes<double>* friction,
                                 const SubstepTerms<double>& terms, bool push, Motion<double>* motions) {
  return solve(block, patches, friction, terms, push, motions);
}

}  // namespace poise::response::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::response {

HWY_EXPORT(prepare_float);
HWY_EXPORT(prepare_double);
HWY_EXPORT(warm_float);
HWY_EXPORT(warm_double);
HWY_EXPORT(solve_float);
HWY_EXPORT(solve_double);

namespace {
template <class T>
T* start(std::span<T> lanes) {
  return lanes.empty() ? nullptr : lanes.data();
}
}  // namespace

void prepare_patch(const PairLanes<float>& pairs, const PlaceLanes<float>& places, float still_mps, PatchLanes<float>& patch, FrictionLanes<float>* friction) {
  HWY_DYNAMIC_DISPATCH(prepare_float)(pairs, places, still_mps, patch, friction);
}
void prepare_patch(const PairLanes<double>& pairs, const PlaceLanes<double>& places, double still_mps, PatchLanes<double>& patch,
                   FrictionLanes<double>* friction) {
  HWY_DYNAMIC_DISPATCH(prepare_double)(pairs, places, still_mps, patch, friction);
}
void warm_block(RestBlock& block, std::span<const PatchLanes<float>> patches, std::span<const FrictionLanes<float>> friction, Motion<float>* motions) {
  HWY_DYNAMIC_DISPATCH(warm_float)(block, patches.data(), start(friction), motions);
}
void warm_block(RestBlock& block, std::span<const PatchLanes<double>> patches, std::span<const FrictionLanes<double>> friction, Motion<double>* motions) {
  HWY_DYNAMIC_DISPATCH(warm_double)(block, patches.data(), start(friction), motions);
}
SweepChange<float> solve_block(RestBlock& block, std::span<PatchLanes<float>> patches, std::span<FrictionLanes<float>> friction,
                               const SubstepTerms<float>& terms, bool push, Motion<float>* motions) {
  return HWY_DYNAMIC_DISPATCH(solve_float)(block, patches.data(), start(friction), terms, push, motions);
}
SweepChange<double> solve_block(RestBlock& block, std::span<PatchLanes<double>> patches, std::span<FrictionLanes<double>> friction,
                                const SubstepTerms<double>& terms, bool push, Motion<double>* motions) {
  return HWY_DYNAMIC_DISPATCH(solve_double)(block, patches.data(), start(friction), terms, push, motions);
}

}  // namespace poise::response
#endif
