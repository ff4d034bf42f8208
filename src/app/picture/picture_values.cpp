// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <system_error>

#include "app/picture/frame_picture.h"

namespace poise::io {
namespace {

/// Reads numbers, each with the sign that must stand after it.
template <class T>
bool read_number(const char*& at, const char* end, T& value) {
  const auto [stop, failure] = std::from_chars(at, end, value);
  at = stop;
  return failure == std::errc{};
}

bool read_point(const char*& at, const char* end, Vec3& point) {
  constexpr double kFarthest = 1e9;
  for (int k = 0; k < 3; ++k) {
    if (k > 0 && (at == end || *at++ != ',')) return false;
    double value = 0;
    if (!read_number(at, end, value) || !(std::abs(value) <= kFarthest)) return false;
    point[k] = value;
  }
  return true;
}

}  // namespace

Result<PictureCamera> parse_picture_camera(const std::string& name, const std::string& text) {
  const auto wrong = [&](const char* rule) { return bad_input(fmt::format("{} = {}, {}", name, text, rule)); };
  constexpr const char* kForm =
      "must be x,y,z:tx,ty,tz or x,y,z:tx,ty,tz:fov_deg: where it stands, where it looks (m, at most 1e9), its "
      "vertical angle";
  const char* at = text.data();
  const char* const end = at + text.size();
  PictureCamera camera;
  if (!read_point(at, end, camera.position_m) || at == end || *at++ != ':' || !read_point(at, end, camera.look_at_m))
    return wrong(kForm);
  if (at != end) {
    double degrees = 0;
    if (*at++ != ':' || !read_number(at, end, degrees) || at != end) return wrong(kForm);
    if (!(degrees > 0 && degrees < 180)) return wrong("the angle must be above 0 and below 180 degrees");
    camera.vertical_fov_rad = degrees * std::numbers::pi / 180;
  }
  if ((camera.look_at_m - camera.position_m).norm() < 1e-6)
    return wrong("the camera must look at a point at least 1e-6 m from where it stands");
  return camera;
}

Result<std::array<std::uint32_t, 2>> parse_picture_size(const std::string& name, const std::string& text) {
  const auto wrong = [&] {
    return bad_input(fmt::format("{} = {}, must be WxH with whole numbers from {} to {}", name, text, kLeastPicturePx,
                                 kMostPicturePx));
  };
  const char* at = text.data();
  const char* const end = at + text.size();
  std::array<std::uint32_t, 2> size_px{};
  if (!read_number(at, end, size_px[0]) || at == end || *at++ != 'x' || !read_number(at, end, size_px[1]) || at != end)
    return wrong();
  for (const std::uint32_t px : size_px) {
    if (px < kLeastPicturePx || px > kMostPicturePx) return wrong();
  }
  return size_px;
}

}  // namespace poise::io
