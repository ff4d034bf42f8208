// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/export/frame_choice.h"

namespace poise::capture {

/// A frame as VTK XML PolyData (.vtp): a point at the centre of mass of each body, with the arrays number, shape,
/// radius (m), orientation (w x y z), state, level, priority, speed (m/s; 0 in the first frame) and mass (kg). ParaView
/// draws shapes at them by its filter Glyph, with the orientation as a quaternion.
class FrameDrawer {
 public:
  explicit FrameDrawer(const CaptureReader& reader) : reader_(reader) {}
  /// Frames in order.
  std::string vtp(const PackedFrame& frame);

 private:
  const CaptureReader& reader_;
  std::vector<Vec3> position_m_;  // one a row: in the last frame that had the body
  std::vector<double> time_s_;    // likewise; below 0 where there was none
};

/// The triangles of a shape as .vtp.
std::string shape_vtp(const CapturedShape& shape, double reach_m);

/// The list of frames (.pvd) that ParaView opens: times and file names.
std::string pvd(const std::vector<std::pair<double, std::string>>& frames);

}  // namespace poise::capture
