// SPDX-License-Identifier: MIT
#pragma once

#include "poise/scheduler/policy.h"
#include "poise/step.h"

namespace poise::simulation {

/// Nearer than this nothing gets larger: a contact at the eye must not outweigh the world. Chosen.
inline constexpr double kNearestSeenM = 0.05;
/// The least part of an error that is seen across the view ray. Chosen.
inline constexpr double kLeastAcross = 0.1;

/// Where and how a pair meets, for the viewer's sake.
struct PairView {
  Vec3 point_m = Vec3::Zero();  ///< world frame
  Vec3 normal = Vec3::UnitZ();  ///< about unit
  double extent_m = 0;          ///< radius of the smaller body
  double closing_mps = 0;
  double importance = 1;
  std::uint32_t frames_waited = 0;
  double gap_m = 0;  ///< as it was answered, >= 0
  double delay_s = 0;
  double age_s = 0;
  double separation = 0;  ///< PairCues::separation
  std::uint16_t crowd = 0;
  bool hidden = false;
  bool attended = false;
};

/// A view with what all questions about it share. Made of a view by itself, so that who asks once need not name it.
struct ViewQuery {
  ViewQuery(const View& from);  // NOLINT(google-explicit-constructor)
  View view;
  Vec3 up = Vec3::UnitZ(), right = Vec3::UnitX();  ///< of the picture, unit
  double tangent_up = 0, tangent_right = 0;        ///< of half the angles of view
  double per_up = 1, per_right = 1;                ///< cosines of these
};

/// What the viewer can notice of a pair. Without a view: everything alike but what a viewer need not see. The visible
/// angle of an error is that of its part across the view ray: sin(angle between normal and ray) / distance, at least a
/// tenth of it. Of the policy its parameters outside_frustum and plain_angle_radpm count, and the eccentricity is not
/// measured where its weight is 0. Any thread.
scheduler::PairCues cues_of(const ViewQuery& view_query, const PairView& pair, const scheduler::Policy& policy = {});

/// Does a ball meet the view's frustum?
bool in_frustum(const ViewQuery& view_query, const Vec3& center_m, double radius_m);

}  // namespace poise::simulation
