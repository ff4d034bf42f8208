// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "poise/result.h"
#include "poise/types.h"

namespace poise::bench {

/// A ball of radius 0.25 m, or a box of that half side.
struct TrialBody {
  double mass_kg = 1;
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
  bool box = false;
};

/// What a world stands on, besides nothing else.
enum class Ground {
  Plane,     ///< z = 0
  InsideOut  ///< the mesh of a box of 8 x 8 x 2 m with its top at z = 0, every triangle turned to the inside
};

/// An engine as the trials need it: a world with gravity. Each call gives the refusal, if the engine refuses.
struct TrialEngine {
  std::string version;
  std::function<Status(const TrialBody&)> add;
  /// A body of 1 kg at 2 m whose mesh, or hull, is eight times the same point.
  std::function<Status()> add_degenerate;
  std::function<Status(std::size_t body, const Vec3& velocity_mps)> set_velocity;
  std::function<Status(double dt_s)> step;
  std::function<std::vector<Vec3>()> positions_m;  ///< of all that were added
};

TrialEngine trial_of_poise(Ground ground);
TrialEngine trial_of_bullet(Ground ground);
TrialEngine trial_of_ode(Ground ground);

}  // namespace poise::bench
