// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "capture/capture_reader.h"
#include "capture/packed_pose.h"
#include "poise/result.h"
#include "poise/scene/scene.h"

namespace poise::io {

/// A body of a picture.
struct DrawnBody {
  std::uint32_t shape = 0;
  capture::Pose pose;
  bool given = false;  ///< static, or moved by the scene
  /// The deepest level that a pair of the body had reached, kPolygonBin for polygons; none: it has no pair, or sleeps.
  std::optional<Level> level;
};

/// What a picture shows of a frame; a run and its capture give the same but for rounded poses.
struct DrawnFrame {
  std::string scene;
  std::uint64_t frame = 0;  ///< frames done
  double time_s = 0;
  View view;                                       ///< of the scene's camera; not present without one
  std::array<double, 2> resolution_px{1280, 720};  ///< of the scene's camera
  Vec3 up = Vec3::UnitZ();                         ///< against gravity
  std::vector<DrawnBody> bodies;
};

/// A run as its last step left it. Refused: a body that somebody else removed from the World.
Result<DrawnFrame> drawn_frame(const Scene& scene, SceneRun& run, std::uint64_t frame, double time_s);

/// A frame of a capture.
DrawnFrame drawn_frame(const capture::CaptureReader& reader, const capture::PackedFrame& frame);

}  // namespace poise::io
