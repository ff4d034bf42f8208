// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/iterations/mixing_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include "solver/iterations/mixing_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Multiplications and additions stay apart, as in lane_math_inl.h.

NotedStep note(std::span<const double> before, std::span<const double> after, std::size_t step,
               const StepLists& lists) {
  constexpr std::size_t kDepth = AndersonMixing::kDepth;
  const hn::CappedTag<double, kDepth> d;
  using V = hn::Vec<decltype(d)>;
  constexpr std::size_t kRegisters = kDepth / hn::MaxLanes(decltype(d)());
  alignas(64) double indices[kDepth];
  for (std::size_t k = 0; k < kDepth; ++k) indices[k] = static_cast<double>(k);
  const V index = hn::Set(d, static_cast<double>(step));
  V with_step[kRegisters], with_last[kRegisters];
  for (std::size_t r = 0; r < kRegisters; ++r) with_step[r] = with_last[r] = hn::Zero(d);
  NotedStep made;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const double residual = after[i] - before[i];
    made.residual_square += residual * residual;
    const V by_step = hn::Set(d, residual - lists.residual[i]);
    const V by_last = hn::Set(d, residual);
    lists.after_step[i] = after[i] - lists.after[i];
    lists.residual[i] = residual;
    lists.after[i] = after[i];
    // The row is changed in its registers: a vector that is read where a number has just been written waits for it.
    double* const row = lists.residual_steps.data() + i * kDepth;
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const auto own = hn::Eq(hn::Load(d, indices + r * hn::Lanes(d)), index);
      const V here = hn::IfThenElse(own, by_step, hn::LoadU(d, row + r * hn::Lanes(d)));
      hn::StoreU(here, d, row + r * hn::Lanes(d));
      with_step[r] = hn::Add(with_step[r], hn::Mul(by_step, here));
      with_last[r] = hn::Add(with_last[r], hn::Mul(here, by_last));
    }
  }
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

HWY_EXPORT(note);
HWY_EXPORT(subtract);

NotedStep note_step(std::span<const double> before, std::span<const double> after, std::size_t step,
                    const StepLists& lists) {
  return HWY_DYNAMIC_DISPATCH(note)(before, after, step, lists);
}

void subtract_steps(std::span<const double* const> steps, std::span<const double> parts, std::span<double> from) {
  HWY_DYNAMIC_DISPATCH(subtract)(steps, parts, from);
}

}  // namespace poise::solver
#endif
