// SPDX-License-Identifier: MIT
#pragma once

#include "frame/scenes.h"

/// What tests of islands that wait share.
namespace poise {

inline StepInput unlimited() { return step_of(1.0 / 60); }

inline WorldSettings gravity_on(int threads = 1) {
  WorldSettings settings = one_thread_with_gravity();
  settings.threads = threads;
  return settings;
}

inline bool same(const BodyState& x, const BodyState& y) {
  return x.position_m == y.position_m && x.orientation.coeffs() == y.orientation.coeffs() &&
         x.velocity_mps == y.velocity_mps && x.angular_velocity_radps == y.angular_velocity_radps;
}

}  // namespace poise
