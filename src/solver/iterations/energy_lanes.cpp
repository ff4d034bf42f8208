// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solver/iterations/energy_lanes.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include "solver/iterations/energy_lanes.h"
#include "solver/lane_math_inl.h"

HWY_BEFORE_NAMESPACE();
namespace poise::solver::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

double kinetic(std::span<const BodyEnergies> bodies, const MotionChange<double>* changes) {
  const hn::CappedTag<double, kLanes> d;
  using V = hn::Vec<decltype(d)>;
  alignas(64) double joules[kLanes];
  double total_j = 0;
  for (const BodyEnergies& of : bodies) {
    for (std::size_t lane = 0; lane < of.count; lane += hn::Lanes(d)) {
      const Columns<V> one = gather(d, changes, of.name + lane, 0);
      const Columns<V> two = gather(d, changes, of.name + lane, 4);
      const Triple<V> v = sum(load(d, of.velocity_mps, lane), Triple<V>{one.at[0], one.at[1], one.at[2]});
      const Triple<V> w = sum(load(d, of.spin_radps, lane), Triple<V>{one.at[3], two.at[0], two.at[1]});
      const Turn<V> inertia = {
          {load(d, of.inertia_kgm2[0], lane), load(d, of.inertia_kgm2[1], lane), load(d, of.inertia_kgm2[2], lane)}};
      const V product = hn::Add(hn::Mul(hn::Load(d, of.kg + lane), dot(v, v)), dot(w, turned(inertia, w)));
      hn::Store(hn::Mul(hn::Set(d, 0.5), product), d, joules + lane);
    }
    for (std::size_t k = 0; k < of.count; ++k) total_j += joules[k];
  }
  return total_j;
}

}  // namespace poise::solver::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::solver {

HWY_EXPORT(kinetic);

double kinetic_j(std::span<const BodyEnergies> bodies, const MotionChange<double>* changes) {
  return HWY_DYNAMIC_DISPATCH(kinetic)(bodies, changes);
}

}  // namespace poise::solver
#endif
