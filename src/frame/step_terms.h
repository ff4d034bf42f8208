// SPDX-License-Identifier: MIT
#pragma once

#include "poise/world.h"

namespace poise::simulation {

/// What all stages of one step go by. The reference and the pair probe choose their own.
struct StepTerms {
  double dt_s = 1.0 / 60.0;
  Vec3 gravity_mps2 = Vec3::Zero();
  ContactModel contact = ContactModel::Fitted;
  Level max_level = kMaxTreeDepth;
  bool polygons = false;
  bool backtracking = false;
};

inline StepTerms terms_of(const WorldSettings& settings, const StepInput& input) {
  return {input.dt_s, settings.gravity_mps2, settings.contact, input.max_level, input.polygons, input.backtracking};
}

}  // namespace poise::simulation
