// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "poise/reference.h"
#include "poise/step.h"

namespace poise::simulation {

/// A moving body in the run and in its reference. SI units, world frame.
struct ComparedBody {
  Vec3 dv_mps = Vec3::Zero(), dw_radps = Vec3::Zero();                      ///< change in the step, in the run
  Vec3 reference_dv_mps = Vec3::Zero(), reference_dw_radps = Vec3::Zero();  ///< the same in the reference
  Mat3 inertia_per_mass_m2 = Mat3::Zero();                                  ///< I / m
  double weight = 1;                                                        ///< s
  std::uint32_t slot = 0;
};

/// eps^2 of a body, as in ReferenceFigures, m^2/s^2.
double squared_error_m2ps2(const ComparedBody& body);

/// A pair in the run and in its reference.
struct ComparedPair {
  std::uint32_t a = 0, b = 0;  ///< slots
  double run_ns = 0;           ///< size of the impulse in the run, N s
  double reference_ns = 0;     ///< in the reference
  double gap_m = 0;            ///< separation of the true surfaces at the start; set only for contacts of the run
  double gap_px = 0;
};

/// Impulses below this share of the largest one of a frame count as 0: ten times the tolerance of the reference.
inline constexpr double kNoImpulse = 1e-9;

/// Least size of the impulse with which a pair of this frame counts as a contact, N s; > 0 unless all are 0.
double least_impulse_ns(std::span<const ComparedPair> pairs);
inline bool counts_as_touch(double impulse_ns, double least_ns) { return impulse_ns > 0 && impulse_ns >= least_ns; }

/// Weight of a body's error by its visibility, docs/method.md; it is not a cue of a policy. Our definition:
///     s = visible min(1, (size / 1 degree)^2) / (1 + eccentricity / 2.5 degrees)^2
/// size = 2 asin(R / d), the angular size of its bounding ball; eccentricity = angle between gaze and its centre;
/// visible = 1, or 0.25 if `hidden`, or 0.05 if the bounding ball is outside the frustum, where `hidden` is ignored. 1
/// without a view.
double error_weight(const View& view, const Vec3& center_m, double radius_m, bool hidden);

/// Height in pixels of the picture in which separations are measured.
inline constexpr double kPictureHeightPx = 1080;
/// Size in pixels of a length across the view at a point: length 1080 / (2 d tan(fov / 2)), with d >= 0.05 m the
/// distance from the viewer.
double length_px(const View& view, const Vec3& point_m, double length_m);

/// E, E_rel and E_seen over `bodies` (all of them touched), contacts and separations over `pairs`. Sums in the given
/// order.
ReferenceFigures compare_frames(std::span<const ComparedBody> bodies, std::span<const ComparedPair> pairs, bool view);

}  // namespace poise::simulation
