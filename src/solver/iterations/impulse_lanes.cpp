// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/iterations/impulse_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include "solver/iterations/impulse_lanes.h"
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

// Some impulses, each times its root.
template <class D, class V>
HWY_INLINE void write_listed(D d, const ContactBlock& block, const Impulses<V>& impulse, const double* roots,
                             double* to, std::size_t lane) {
  const Impulses<V> root = read_numbers(d, block, roots, lane);
  const Impulses<V> listed{hn::Mul(root.along, impulse.along),
                           {hn::Mul(root.across.x, impulse.across.x), hn::Mul(root.across.y, impulse.across.y),
                            hn::Mul(root.across.z, impulse.across.z)}};
  write_numbers(d, block, listed, to, lane);
}

void list(const ContactBlock& block, std::span<const PointLanes<double>> points, const double* roots, double* into) {
  const hn::CappedTag<double, kLanes> d;
  const std::size_t numbers = numbers_of_point(block);
  for (const PointLanes<double>& point : points) {
    for (std::size_t lane = 0; lane < block.count; lane += hn::Lanes(d)) {
      write_listed(d, block, impulses_of(d, point, lane), roots, into, lane);
    }
    roots += numbers;
    into += numbers;
  }
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

// Sets the lanes of `used`.
template <class D, class V, class M>
HWY_INLINE void set_lanes(D d, const M& used, const V& value, double* to) {
  hn::Store(hn::IfThenElse(used, value, hn::Load(d, to)), d, to);
}
template <class D, class V, class M>
HWY_INLINE void set_across(D d, const M& used, const Triple<V>& value, PointLanes<double>& point, std::size_t lane) {
  set_lanes(d, used, value.x, point.friction_impulse[0] + lane);
  set_lanes(d, used, value.y, point.friction_impulse[1] + lane);
  set_lanes(d, used, value.z, point.friction_impulse[2] + lane);
}

void change(const ContactBlock& block, const PairLanes<double>& pairs, std::span<PointLanes<double>> points,
            const double* roots, double* wanted, double* before) {
  const hn::CappedTag<double, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  const std::size_t numbers = numbers_of_point(block);
  for (PointLanes<double>& point : points) {
    for (std::size_t lane = 0; lane < block.count; lane += hn::Lanes(d)) {
      const Impulses<V> number = read_numbers(d, block, wanted, lane);
      const Impulses<V> root = read_numbers(d, block, roots, lane);
      const Impulses<V> old = impulses_of(d, point, lane);
      const auto used = hn::FirstN(d, block.count - lane);
      // Zero where it is none, and where it is a zero with a sign.
      Impulses<V> made{hn::Max(without_root(d, number.along, root.along), hn::Zero(d)), old.across};
      set_lanes(d, used, hn::Sub(made.along, old.along), point.impulse + lane);
      if (block.frictional) {
        const Triple<V> across = {without_root(d, number.across.x, root.across.x),
                                  without_root(d, number.across.y, root.across.y),
                                  without_root(d, number.across.z, root.across.z)};
        made.across = within_cone(d, across, load(d, point.normal, lane),
                                  hn::Mul(hn::Load(d, pairs.friction + lane), made.along));
        set_across(d, used, difference(made.across, old.across), point, lane);
      }
      write_numbers(d, block, old, before, lane);
      write_numbers(d, block, made, wanted, lane);
    }
    roots += numbers;
    wanted += numbers;
    before += numbers;
  }
}

void set(const ContactBlock& block, std::span<PointLanes<double>> points, const double* impulses, const double* roots,
         double* into) {
  const hn::CappedTag<double, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  const std::size_t numbers = numbers_of_point(block);
  for (PointLanes<double>& point : points) {
    for (std::size_t lane = 0; lane < block.count; lane += hn::Lanes(d)) {
      const Impulses<V> made = read_numbers(d, block, impulses, lane);
      const auto used = hn::FirstN(d, block.count - lane);
      set_lanes(d, used, made.along, point.impulse + lane);
      if (block.frictional) set_across(d, used, made.across, point, lane);
      write_listed(d, block, made, roots, into, lane);
    }
    impulses += numbers;
    roots += numbers;
    into += numbers;
  }
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

void set_impulses(const ContactBlock& block, std::span<PointLanes<double>> manifold_points, const double* impulses,
                  const double* roots, double* into) {
  HWY_DYNAMIC_DISPATCH(set)(block, manifold_points, impulses, roots, into);
}

}  // namespace poise::solver
#endif
