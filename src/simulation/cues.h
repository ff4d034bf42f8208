// SPDX-License-Identifier: MIT
#pragma once

#include "poise/scheduler/policy.h"
#include "poise/step.h"

namespace poise::simulation {

/// Where and how a pair meets, for the viewer's sake.
struct PairSighting {
  Vec3 point_m = Vec3::Zero();          ///< world frame
  Vec3 normal = Vec3::UnitZ();          ///< about unit
  double extent_m = 0;                  ///< radius of the smaller body
  double closing_mps = 0;
  double importance = 1;
  std::uint32_t frames_waited = 0;
};

/// What the viewer can notice of a pair. Without a view: everything alike. The visible angle of an error is that of its
/// part across the view ray: sin(angle between normal and ray) / distance, at least a tenth of it. Any thread.
scheduler::PairCues cues_of(const View& view, const PairSighting& pair);

/// Does a ball meet the view's frustum?
bool in_frustum(const View& view, const Vec3& center_m, double radius_m);

}  // namespace poise::simulation
