// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "capture/export/frame_choice.h"

namespace poise::capture {

/// The poses of a body over the chosen frames: those at which it begins or ends to rest, and all between. Linear
/// interpolation gives every pose that is left out.
struct BodyKeys {
  std::uint32_t first = 0, last = 0;  ///< index of the first and last chosen frame that has the body
  std::vector<std::uint32_t> frame;   ///< indices of chosen frames, ascending; empty: the body is in none
  std::vector<PackedPose> pose;       ///< one each
};

/// A camera at a chosen frame.
struct CameraKey {
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();  ///< turns -z to where it looks and +y to its top
  double vertical_fov_rad = 1, aspect = 1;
};

/// The chosen frames, body by body.
struct BodyTracks {
  std::vector<double> time_s;     ///< of each chosen frame, from the first one
  std::vector<BodyKeys> bodies;   ///< one a row of the table of bodies
  std::vector<CameraKey> camera;  ///< one a frame, or none where the scene has no camera
  double reach_m = 1;             ///< how far from the origin bodies that move come
};

/// Frames are read until `goes_on` (empty: always) says no.
Result<BodyTracks> body_tracks(CaptureReader& reader, const FrameChoice& choice,
                               const std::function<bool()>& goes_on = {});

}  // namespace poise::capture
