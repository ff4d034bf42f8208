// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/impulse_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include "solver/impulse_lanes.h"
#include "solver/lane_math_inl.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Of a contact point in some lanes: along the normal, and across it.
template <class V>
struct Impulses {
  V along;
  Triple<V> across;
};

template <class D>
HWY_INLINE Impulses<hn::Vec<D>> impulses_of(D d, const PointLanes<double>& point, std::size_t lane) {
  return {hn::Load(d, point.impulse + lane), load(d, point.friction_impulse, lane)};
}

// Those of a contact point begin at `from`.
template <class D>
HWY_INLINE Impulses<hn::Vec<D>> read_numbers(D d, const ContactBlock& block, const double* from, std::size_t lane) {
  if (!block.frictional) {
    const auto zero = hn::Zero(d);
    return {hn::LoadU(d, from + lane), {zero, zero, zero}};
  }
  const auto row = [&](std::size_t k) { return from + 4 * (lane + k); };
  const Columns<hn::Vec<D>> columns = columns_of(d, row);
  return {columns.at[0], {columns.at[1], columns.at[2], columns.at[3]}};
}
template <class D, class V>
HWY_INLINE void write_numbers(D d, const ContactBlock& block, const Impulses<V>& impulses, double* to,
                              std::size_t lane) {
  if (!block.frictional) {
    hn::BlendedStore(impulses.along, hn::FirstN(d, block.count - lane), d, to + lane);
    return;
  }
  const std::uint32_t in_use = ((1U << block.count) - 1U) >> lane;
  const auto row = [&](std::size_t k) { return to + 4 * (lane + k); };
  store_rows(d, {{impulses.along, impulses.across.x, impulses.across.y, impulses.across.z}}, in_use, row);
}

// Calls visit(contact point, where its numbers begin, lane) for all lanes of a block that are in use.
template <class D, class Points, class Visit>
HWY_INLINE void for_lanes(D d, const ContactBlock& block, Points points, Visit&& visit) {
  const std::size_t numbers = std::size_t{block.count} * (block.frictional ? 4U : 1U);
  for (std::size_t p = 0; p < points.size(); ++p) {
    for (std::size_t lane = 0; lane < block.count; lane += hn::Lanes(d)) visit(points[p], p * numbers, lane);
  }
}

void list(const ContactBlock& block, std::span<const PointLanes<double>> points, const double* roots, double* into) {
  const hn::CappedTag<double, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  for_lanes(d, block, points, [&](const PointLanes<double>& point, std::size_t at, std::size_t lane) HWY_ATTR {
    const Impulses<V> root = read_numbers(d, block, roots + at, lane);
    const Impulses<V> impulse = impulses_of(d, point, lane);
    write_numbers(d, block,
                  Impulses<V>{hn::Mul(root.along, impulse.along),
                              {hn::Mul(root.across.x, impulse.across.x), hn::Mul(root.across.y, impulse.across.y),
                               hn::Mul(root.across.z, impulse.across.z)}},
                  into + at, lane);
  });
}

// What was extrapolated, without its roots; nothing where nothing moves.
template <class D, class V>
HWY_INLINE V without_root(D d, const V& number, const V& root) {
  const auto moves = hn::Gt(root, hn::Zero(d));
  return hn::IfThenElseZero(moves, hn::Div(number, hn::IfThenElse(moves, root, hn::Set(d, 1.0))));
}

// Within the friction cone. A component along the normal would cancel against the normal impulse, and no later
// iteration would remove it.
template <class D, class V>
HWY_INLINE Triple<V> within_cone(D d, const Triple<V>& wanted, const Triple<V>& normal, const V& most) {
  const V one = hn::Set(d, 1.0);
  const Triple<V> across = difference(wanted, scaled(dot(wanted, normal), normal));
  const V size = hn::Sqrt(dot(across, across));
  const auto beyond = hn::Gt(size, most);
  return scaled(hn::IfThenElse(beyond, hn::Div(most, hn::IfThenElse(beyond, size, one)), one), across);
}

void change(const ContactBlock& block, const PairLanes<double>& pairs, std::span<PointLanes<double>> points,
            const double* roots, double* wanted, double* before) {
  const hn::CappedTag<double, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  for_lanes(d, block, points, [&](PointLanes<double>& point, std::size_t at, std::size_t lane) HWY_ATTR {
    const Impulses<V> number = read_numbers(d, block, wanted + at, lane);
    const Impulses<V> root = read_numbers(d, block, roots + at, lane);
    const Impulses<V> old = impulses_of(d, point, lane);
    const auto used = hn::FirstN(d, block.count - lane);
    // Zero where it is none, and where it is a zero with a sign.
    Impulses<V> made{hn::Max(without_root(d, number.along, root.along), hn::Zero(d)), old.across};
    const auto change_to = [&](const V& now, const V& then, double* to)
                               HWY_ATTR { hn::Store(hn::IfThenElse(used, hn::Sub(now, then), then), d, to + lane); };
    change_to(made.along, old.along, point.impulse);
    if (block.frictional) {
      const Triple<V> across = {without_root(d, number.across.x, root.across.x),
                                without_root(d, number.across.y, root.across.y),
                                without_root(d, number.across.z, root.across.z)};
      made.across =
          within_cone(d, across, load(d, point.normal, lane), hn::Mul(hn::Load(d, pairs.friction + lane), made.along));
      change_to(made.across.x, old.across.x, point.friction_impulse[0]);
      change_to(made.across.y, old.across.y, point.friction_impulse[1]);
      change_to(made.across.z, old.across.z, point.friction_impulse[2]);
    }
    write_numbers(d, block, old, before + at, lane);
    write_numbers(d, block, made, wanted + at, lane);
  });
}

void set(const ContactBlock& block, std::span<PointLanes<double>> points, const double* impulses) {
  const hn::CappedTag<double, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  for_lanes(d, block, points, [&](PointLanes<double>& point, std::size_t at, std::size_t lane) HWY_ATTR {
    const Impulses<V> made = read_numbers(d, block, impulses + at, lane);
    const auto used = hn::FirstN(d, block.count - lane);
    const auto put = [&](const V& value, double* to)
                         HWY_ATTR { hn::Store(hn::IfThenElse(used, value, hn::Load(d, to + lane)), d, to + lane); };
    put(made.along, point.impulse);
    if (!block.frictional) return;
    put(made.across.x, point.friction_impulse[0]);
    put(made.across.y, point.friction_impulse[1]);
    put(made.across.z, point.friction_impulse[2]);
  });
}

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::solver {

HWY_EXPORT(list);
HWY_EXPORT(change);
HWY_EXPORT(set);

void list_impulses(const ContactBlock& block, std::span<const PointLanes<double>> manifold_points, const double* roots,
                   double* into) {
  HWY_DYNAMIC_DISPATCH(list)(block, manifold_points, roots, into);
}

void change_impulses(const ContactBlock& block, const PairLanes<double>& pairs,
                     std::span<PointLanes<double>> manifold_points, const double* roots, double* wanted,
                     double* before) {
  HWY_DYNAMIC_DISPATCH(change)(block, pairs, manifold_points, roots, wanted, before);
}

void set_impulses(const ContactBlock& block, std::span<PointLanes<double>> manifold_points, const double* impulses) {
  HWY_DYNAMIC_DISPATCH(set)(block, manifold_points, impulses);
}

}  // namespace poise::solver
#endif
