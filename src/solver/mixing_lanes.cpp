// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/mixing_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include "solver/mixing_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Multiplications and additions stay apart, as in lane_math_inl.h.

StepProducts products(std::span<const double> steps, std::span<const double> last, std::size_t step) {
  constexpr std::size_t kDepth = AndersonMixing::kDepth;
  const hn::CappedTag<double, kDepth> d;
  using V = hn::Vec<decltype(d)>;
  constexpr std::size_t kRegisters = kDepth / hn::MaxLanes(decltype(d)());
  V with_step[kRegisters], with_last[kRegisters];
  for (std::size_t r = 0; r < kRegisters; ++r) with_step[r] = with_last[r] = hn::Zero(d);
  for (std::size_t i = 0; i < last.size(); ++i) {
    const double* const of = steps.data() + i * kDepth;
    const V by_step = hn::Set(d, of[step]);
    const V by_last = hn::Set(d, last[i]);
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const V here = hn::LoadU(d, of + r * hn::Lanes(d));
      with_step[r] = hn::Add(with_step[r], hn::Mul(by_step, here));
      with_last[r] = hn::Add(with_last[r], hn::Mul(here, by_last));
    }
  }
  StepProducts made;
  for (std::size_t r = 0; r < kRegisters; ++r) {
    hn::StoreU(with_step[r], d, made.with_step.data() + r * hn::Lanes(d));
    hn::StoreU(with_last[r], d, made.with_last.data() + r * hn::Lanes(d));
  }
  return made;
}

template <class D>
HWY_INLINE void subtract_at(D d, std::size_t i, std::span<const double* const> steps, std::span<const double> parts,
                            std::span<double> from) {
  auto left = hn::LoadU(d, from.data() + i);
  for (std::size_t s = 0; s < steps.size(); ++s)
    left = hn::Sub(left, hn::Mul(hn::Set(d, parts[s]), hn::LoadU(d, steps[s] + i)));
  hn::StoreU(left, d, from.data() + i);
}

void subtract(std::span<const double* const> steps, std::span<const double> parts, std::span<double> from) {
  const hn::ScalableTag<double> d;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= from.size(); i += hn::Lanes(d)) subtract_at(d, i, steps, parts, from);
  for (; i < from.size(); ++i) subtract_at(hn::CappedTag<double, 1>(), i, steps, parts, from);
}

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::solver {

HWY_EXPORT(products);
HWY_EXPORT(subtract);

StepProducts step_products(std::span<const double> steps, std::span<const double> last, std::size_t step) {
  return HWY_DYNAMIC_DISPATCH(products)(steps, last, step);
}

void subtract_steps(std::span<const double* const> steps, std::span<const double> parts, std::span<double> from) {
  HWY_DYNAMIC_DISPATCH(subtract)(steps, parts, from);
}

}  // namespace poise::solver
#endif
