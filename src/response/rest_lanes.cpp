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
    if ((yields >> lane & 1U) == 0) continue;
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
