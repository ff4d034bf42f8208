// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/picture/body_raster.h"
#include "app/picture/drawn_frame.h"
#include "app/picture/picture.h"
#include "poise/result.h"

namespace poise::io {

/// The smallest and the largest width or height of a picture that is asked for.
inline constexpr std::uint32_t kLeastPicturePx = 64;
inline constexpr std::uint32_t kMostPicturePx = 4096;

/// A camera in place of the scene's.
struct PictureCamera {
  Vec3 position_m = Vec3::Zero(), look_at_m = Vec3::UnitX();
  double vertical_fov_rad = 0.87;
};
/// `x,y,z:tx,ty,tz` with `:fov_deg` or without. Refused: any other text, two points that are one, an angle that is not
/// above 0 and below 180. `name` begins the message.
Result<PictureCamera> parse_picture_camera(const std::string& name, const std::string& text);
/// `WxH`. Refused: any other text, and a number that is not from kLeastPicturePx to kMostPicturePx.
Result<std::array<std::uint32_t, 2>> parse_picture_size(const std::string& name, const std::string& text);

struct PictureSettings {
  std::optional<std::array<std::uint32_t, 2>> size_px;  ///< default: the resolution of the scene's camera
  std::optional<PictureCamera> camera;                  ///< default: the scene's, or one that sees all moving bodies
  bool plain = false;                                   ///< without words, colours explained and the ring of the gaze
  int threads = 0;  ///< 0 = as many as the machine has; the picture does not depend on it
};

/// Draws frames of one run. Meshes are drawn by their triangles, other shapes as the balls that they are made of, in
/// the colour of level_color; static bodies and those that the scene moves are brown, bodies with no pair grey. Any
/// thread, one at a time.
class FramePictures {
 public:
  FramePictures(std::vector<capture::CapturedShape> shapes, const PictureSettings& settings);
  [[nodiscard]] Image draw(const DrawnFrame& frame) const;
  /// From where draw() looks.
  [[nodiscard]] View view(const DrawnFrame& frame) const;

 private:
  std::vector<capture::CapturedShape> captured_;
  std::vector<DrawnShape> shapes_;
  PictureSettings settings_;
};

inline constexpr std::array<double, 3> kGivenColor = {0.70, 0.62, 0.52};
inline constexpr std::array<double, 3> kUntouchedColor = {0.66, 0.68, 0.71};
/// Colour of a level: violet (0), blue, green, light green, yellow (4 and deeper), and orange for polygons
/// (kPolygonBin). Each is lighter than the one before but the last, so that they differ without their hue too.
std::array<double, 3> level_color(int level);

}  // namespace poise::io
