// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "collision/contact_sums.h"
#include "collision/pair_frame.h"
#include "collision/patch.h"
#include "poise/types.h"
#include "response/rest.h"

namespace poise::simulation {

/// A place of contact as a pair keeps it: a point of each surface and the direction between them, fixed to the bodies. While both move little,
/// the gap there is n . (p_b - p_a) to second order in what they turn.
struct KeptPlace {
  Vec3 normal = Vec3::UnitZ();     ///< unit, from a to b, in the frame of b
  Vec3 on_a_m = Vec3::Zero();      ///< in the frame of a
  Vec3 on_b_m = Vec3::Zero();      ///< in the frame of b; not used where b is a plane
  double sureness_m = 0;           ///< the gap that is certain is larger by this, >= 0
  double impulse_ns = 0;           ///< of resting contact, a substep
  Vec3 friction_ns = Vec3::Zero(); ///< likewise, in the frame of b
};

/// Two bodies where they are now. Where b is a plane, `height_m` is that of its surface along its normal.
struct PlacedPair {
  const collision::Pose& a;
  const collision::Pose& b;
  bool plane = false;
  double height_m = 0;
};

/// Fixes a place that is given in the frame of a to the bodies. No impulse.
KeptPlace keep(const PlacedPair& pair, const collision::Patch& patch);

/// Where a kept place is now, ready to be solved: world frame.
response::RestPatch placed(const PlacedPair& pair, const KeptPlace& kept);

/// Puts what solving found back. World frame to the frame of b.
void keep_impulse(const PlacedPair& pair, const response::RestPatch& solved, KeptPlace& kept);

}  // namespace poise::simulation
