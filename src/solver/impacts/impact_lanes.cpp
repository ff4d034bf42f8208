// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/impacts/impact_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>

#include "solver/impacts/impact_lanes.h"
#include "solver/lane_math_inl.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Where the numbers of a row begin, in numbers (impact_row.h): four are read at a time.
constexpr std::size_t kWrenchOfRow = 0, kPlaceOfRow = 12, kTurnsOfRow = 16, kTermsOfRow = 24, kPointImpulseOfRow = 28;

// The bodies of some rows.
template <class V>
struct Motions {
  Triple<V> v, w;
  V inverse_mass;
  V flags;  // carried along, so that four numbers can be stored
};

template <class D>
HWY_INLINE Motions<hn::Vec<D>> motions(D d, const SolverBody* bodies, const std::uint32_t* which) {
  const auto one = gather(d, bodies, which, 0);
  const auto two = gather(d, bodies, which, 4);
  return {{one.at[0], one.at[1], one.at[2]}, {one.at[3], two.at[0], two.at[1]}, two.at[2], two.at[3]};
}

template <class D, class M>
HWY_INLINE std::uint32_t bits_of(D d, M mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
}

// Bodies that are not dynamic are never written: others read them at the same time.
template <class D, class V>
HWY_INLINE void store_motions(D d, const Motions<V>& of, SolverBody* bodies, const std::uint32_t* which) {
  const std::uint32_t dynamic = bits_of(d, hn::Gt(of.inverse_mass, hn::Zero(d)));
  scatter(d, {{of.v.x, of.v.y, of.v.z, of.w.x}}, dynamic, bodies, which, 0);
  scatter(d, {{of.w.y, of.w.z, of.inverse_mass, of.flags}}, dynamic, bodies, which, 4);
}

// The bits of some places, those in use.
template <class D, class M>
HWY_INLINE std::uint64_t bits_at(D d, M mask, std::size_t k, const ImpactBatch& batch) {
  const std::uint64_t bits = std::uint64_t{bits_of(d, mask)} << k;
  return batch.count < ImpactBatch::kRows ? bits & ((std::uint64_t{1} << batch.count) - 1U) : bits;
}

// Until so many rows are there, those that are missing repeat the last one.
HWY_INLINE void pad(ImpactBatch& batch, std::size_t rows) {
  const std::size_t last = batch.count - 1;
  for (std::size_t k = batch.count; k < rows; ++k) {
    batch.row[k] = batch.row[last];
    batch.a[k] = batch.a[last];
    batch.b[k] = batch.b[last];
    batch.lambda_ns[k] = batch.lambda_ns[last];
  }
}

// Calls solve(d, k) for the rows from k on, as many at a time as d has lanes: the last ones in the fewest lanes that
// hold them, because most batches of small scenes have few rows.
template <std::size_t kMost, class Solve>
HWY_INLINE void for_rows(ImpactBatch& batch, std::size_t k, const Solve& solve) {
  const hn::CappedTag<double, kMost> d;
  constexpr std::size_t kHalf = hn::MaxLanes(decltype(d)()) / 2;
  for (; k + kHalf < batch.count; k += hn::Lanes(d)) {
    pad(batch, k + hn::Lanes(d));
    solve(d, k);
  }
  if constexpr (kHalf > 0) for_rows<kHalf>(batch, k, solve);
}

// Approach speed along some wrenches: positive when the two bodies close.
template <class V>
HWY_INLINE V closing_of(const Motions<V>& a, const Motions<V>& b, const Triple<V>& direction, const Triple<V>& moment_a,
                        const Triple<V>& moment_b) {
  return hn::Sub(hn::Add(dot(direction, difference(a.v, b.v)), dot(moment_a, a.w)), dot(moment_b, b.w));
}

// How fast any point within `reach` of the centre of mass of a closes at most.
template <class D, class V>
HWY_INLINE V closing_within(D d, const V& reach, const Triple<V>& a_to_b, const Motions<V>& a, const Motions<V>& b) {
  const Triple<V> moves = sum(difference(a.v, b.v), cross(b.w, a_to_b));
  const Triple<V> turns = difference(a.w, b.w);
  const V most = hn::Add(hn::Sqrt(dot(moves, moves)), hn::Mul(reach, hn::Sqrt(dot(turns, turns))));
  constexpr double kRounding = 1e-6;
  return hn::Mul(hn::Set(d, 1 + kRounding), most);
}

template <class D>
void overlaps_at(D d, const ImpactLanes& lanes, std::size_t k, ImpactBatch& batch) {
  using V = hn::Vec<D>;
  const auto first = gather(d, lanes.overlaps, batch.row + k, 0);
  const auto second = gather(d, lanes.overlaps, batch.row + k, 4);
  const auto third = gather(d, lanes.overlaps, batch.row + k, 6);
  const auto closing = closing_of<V>(motions(d, lanes.bodies, batch.a + k), motions(d, lanes.bodies, batch.b + k),
                                     {first.at[0], first.at[1], first.at[2]}, {first.at[3], second.at[0], second.at[1]},
                                     {second.at[2], second.at[3], third.at[2]});
  batch.rebounds |= bits_at(d, hn::Gt(hn::Mul(third.at[3], closing), hn::Set(d, lanes.still_mps)), k, batch);
}

void overlaps(const ImpactLanes& lanes, ImpactBatch& batch) {
  batch.rebounds = 0;
  for_rows<kLanes>(batch, 0, [&](auto d, std::size_t k) HWY_ATTR { overlaps_at(d, lanes, k, batch); });
}

template <class D>
void look_at(D d, const ImpactLanes& lanes, std::size_t k, ImpactBatch& batch) {
  using V = hn::Vec<D>;
  const V one = hn::Set(d, 1.0);
  const V still = hn::Set(d, lanes.still_mps);
  const V dt = hn::Set(d, lanes.dt_s);
  const auto first = gather(d, lanes.rows, batch.row + k, kWrenchOfRow);
  const auto second = gather(d, lanes.rows, batch.row + k, kWrenchOfRow + 4);
  const auto third = gather(d, lanes.rows, batch.row + k, kWrenchOfRow + 8);
  const auto place = gather(d, lanes.rows, batch.row + k, kPlaceOfRow);
  const Motions<V> a = motions(d, lanes.bodies, batch.a + k);
  const Motions<V> b = motions(d, lanes.bodies, batch.b + k);
  const V closing = closing_of<V>(a, b, {first.at[0], first.at[1], first.at[2]},
                                  {first.at[3], second.at[0], second.at[1]}, {second.at[2], second.at[3], third.at[0]});
  const V mass = third.at[1];
  const V gap = third.at[2];
  const V restitution = third.at[3];
  const auto rebounds = hn::Gt(hn::Mul(restitution, closing), still);
  // The start of this step is nearer to the time of impact than that of the next one. Waiting for overlap would
  // answer half a step late on average, and a late rebound loses speed: it has to climb out of the overlap.
  const auto meets_now = hn::Le(gap, hn::Mul(hn::Mul(hn::Set(d, 0.5), closing), dt));
  const V now = hn::Mul(hn::Mul(hn::Add(one, hn::IfThenElseZero(rebounds, restitution)), closing), mass);
  const auto meets_later = hn::AndNot(rebounds, hn::Gt(hn::Mul(closing, dt), gap));
  const V later = hn::Mul(hn::Sub(closing, hn::Div(gap, dt)), mass);
  const V lambda = hn::IfThenElseZero(hn::Gt(closing, still),
                                      hn::IfThenElse(meets_now, now, hn::IfThenElseZero(meets_later, later)));
  hn::Store(lambda, d, batch.lambda_ns + k);
  batch.needs |= bits_at(d, hn::Gt(lambda, hn::Zero(d)), k, batch);
  batch.rebounds |= bits_at(d, rebounds, k, batch);
  const V most = closing_within(d, place.at[3], {place.at[0], place.at[1], place.at[2]}, a, b);
  const auto might = hn::And(hn::Gt(place.at[3], hn::Zero(d)), hn::Gt(hn::Mul(restitution, most), still));
  batch.overlaps_rebound |= bits_at(d, might, k, batch);
}

void look(const ImpactLanes& lanes, ImpactBatch& batch) {
  batch.needs = batch.rebounds = batch.overlaps_rebound = 0;
  for_rows<kLanes>(batch, 0, [&](auto d, std::size_t k) HWY_ATTR { look_at(d, lanes, k, batch); });
}

// The impulse lambda along l, with turns per unit of it, applied to b and its opposite to a.
template <class D, class V>
HWY_INLINE void push(D d, const V& lambda, const Triple<V>& l, const Triple<V>& turn_a, const Triple<V>& turn_b,
                     Motions<V>& a, Motions<V>& b) {
  const V zero = hn::Zero(d);
  a.v = difference(a.v, scaled(hn::Mul(lambda, a.inverse_mass), l));
  b.v = sum(b.v, scaled(hn::Mul(lambda, b.inverse_mass), l));
  a.w = difference(a.w, scaled(hn::IfThenElseZero(hn::Gt(a.inverse_mass, zero), lambda), turn_a));
  b.w = sum(b.w, scaled(hn::IfThenElseZero(hn::Gt(b.inverse_mass, zero), lambda), turn_b));
}

// Inverse inertias times t. The sums are in the order of Eigen's, which makes the other wrenches.
template <class D, class V>
HWY_INLINE Triple<V> turned(D d, const Mat3* inverse_inertia, const std::uint32_t* which, const Triple<V>& t) {
  const auto first = gather(d, inverse_inertia, which, 0);
  const auto second = gather(d, inverse_inertia, which, 4);
  alignas(64) double last[kLanes];
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) last[lane] = inverse_inertia[which[lane]](2, 2);
  return {dot(Triple<V>{first.at[0], first.at[3], second.at[2]}, t),
          dot(Triple<V>{first.at[1], second.at[0], second.at[3]}, t),
          hn::Add(hn::Mul(first.at[2], t.x), hn::Add(hn::Mul(second.at[1], t.y), hn::Mul(hn::Load(d, last), t.z)))};
}

// Coulomb friction of the impulses lambda along l: what stops the slip at the contact point, or as much as the cone
// allows.
template <class D, class V>
HWY_INLINE void add_friction(D d, const ImpactLanes& lanes, const ImpactBatch& batch, std::size_t k, const V& lambda,
                             const V& friction, const Triple<V>& l, const Triple<V>& arm_a, Motions<V>& a,
                             Motions<V>& b) {
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1.0);
  const auto place = gather(d, lanes.rows, batch.row + k, kPlaceOfRow);
  const auto given = gather(d, lanes.rows, batch.row + k, kPointImpulseOfRow);
  const Triple<V> arm_b = difference(arm_a, Triple<V>{place.at[0], place.at[1], place.at[2]});
  const V length = hn::Sqrt(dot(l, l));
  const V divisor = hn::IfThenElse(hn::Gt(length, zero), length, one);
  const Triple<V> normal = {hn::Div(l.x, divisor), hn::Div(l.y, divisor), hn::Div(l.z, divisor)};
  Triple<V> slip = difference(difference(sum(b.v, cross(b.w, arm_b)), a.v), cross(a.w, arm_a));
  slip = difference(slip, scaled(dot(slip, normal), normal));
  const V speed = hn::Sqrt(dot(slip, slip));
  const auto slides = hn::And(hn::Gt(friction, zero), hn::Gt(speed, zero));
  const V by = hn::Neg(hn::IfThenElse(slides, speed, one));
  const Triple<V> across = {hn::Div(slip.x, by), hn::Div(slip.y, by), hn::Div(slip.z, by)};
  const Triple<V> moment_a = cross(arm_a, across);
  const Triple<V> moment_b = cross(arm_b, across);
  const Triple<V> turn_a = turned(d, lanes.inverse_inertia, batch.a + k, moment_a);
  const Triple<V> turn_b = turned(d, lanes.inverse_inertia, batch.b + k, moment_b);
  const V moving = hn::Add(a.inverse_mass, b.inverse_mass);
  const V per_mass =
      hn::Add(hn::Add(hn::Mul(dot(across, across), moving), dot(moment_a, turn_a)), dot(moment_b, turn_b));
  // As in prepare_wrench.
  const auto sound = hn::And(hn::IsFinite(per_mass), hn::Gt(per_mass, hn::Mul(hn::Set(d, 1e-7), moving)));
  const auto holds_back = hn::And(slides, sound);
  const V stops = hn::Mul(speed, hn::Div(one, hn::IfThenElse(holds_back, per_mass, one)));
  const V most = hn::Mul(hn::Mul(friction, lambda), length);
  const V impulse = hn::IfThenElseZero(holds_back, hn::IfThenElse(hn::Lt(most, stops), most, stops));
  push(d, impulse, across, turn_a, turn_b, a, b);
  const Triple<V> total = sum(Triple<V>{given.at[0], given.at[1], given.at[2]}, scaled(impulse, across));
  scatter(d, {{total.x, total.y, total.z, given.at[3]}}, bits_of(d, holds_back), lanes.rows, batch.row + k,
          kPointImpulseOfRow);
}

template <class D>
void give_at(D d, const ImpactLanes& lanes, std::size_t k, const ImpactBatch& batch) {
  using V = hn::Vec<D>;
  const auto first = gather(d, lanes.rows, batch.row + k, kWrenchOfRow);
  const auto terms = gather(d, lanes.rows, batch.row + k, kTermsOfRow);
  const auto turns = gather(d, lanes.rows, batch.row + k, kTurnsOfRow);
  const auto more = gather(d, lanes.rows, batch.row + k, kTurnsOfRow + 4);
  const Triple<V> l = {first.at[0], first.at[1], first.at[2]};
  const V lambda = hn::Load(d, batch.lambda_ns + k);
  const V friction = terms.at[2];
  Motions<V> a = motions(d, lanes.bodies, batch.a + k);
  Motions<V> b = motions(d, lanes.bodies, batch.b + k);
  push(d, lambda, l, {turns.at[0], turns.at[1], turns.at[2]}, {turns.at[3], more.at[0], more.at[1]}, a, b);
  if (!hn::AllFalse(d, hn::Gt(friction, hn::Zero(d))))
    add_friction(d, lanes, batch, k, lambda, friction, l, {more.at[2], more.at[3], terms.at[0]}, a, b);
  store_motions(d, a, lanes.bodies, batch.a + k);
  store_motions(d, b, lanes.bodies, batch.b + k);
}

void give(const ImpactLanes& lanes, ImpactBatch& batch) {
  for_rows<kLanes>(batch, 0, [&](auto d, std::size_t k) HWY_ATTR { give_at(d, lanes, k, batch); });
}

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::solver {

HWY_EXPORT(look);
HWY_EXPORT(overlaps);
HWY_EXPORT(give);

void look_at_rows(const ImpactLanes& lanes, ImpactBatch& batch) {
  if (batch.count > 0) HWY_DYNAMIC_DISPATCH(look)(lanes, batch);
}

void look_at_overlaps(const ImpactLanes& lanes, ImpactBatch& batch) {
  if (batch.count > 0) HWY_DYNAMIC_DISPATCH(overlaps)(lanes, batch);
}

void give_impulses(const ImpactLanes& lanes, ImpactBatch& batch) {
  if (batch.count > 0) HWY_DYNAMIC_DISPATCH(give)(lanes, batch);
}

}  // namespace poise::solver
#endif
