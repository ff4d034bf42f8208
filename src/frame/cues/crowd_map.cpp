// SPDX-License-Identifier: MIT
#include "frame/cues/crowd_map.h"

#include <algorithm>

namespace poise::simulation {

void CrowdMap::begin(const ViewQuery& view_query) {
  view_query_ = view_query;
  events_.fill(0);
}

std::optional<std::size_t> CrowdMap::cell_of(const Vec3& point_m) const {
  const Vec3 ray = point_m - view_query_.view.position_m;
  const double depth_m = ray.dot(view_query_.view.forward);
  if (!(depth_m > 0)) return std::nullopt;
  const double across = 0.5 + 0.5 * ray.dot(view_query_.right) / (depth_m * view_query_.tangent_right);
  const double upward = 0.5 + 0.5 * ray.dot(view_query_.up) / (depth_m * view_query_.tangent_up);
  if (!(across >= 0 && across < 1 && upward >= 0 && upward < 1)) return std::nullopt;
  const auto column = std::min(static_cast<std::size_t>(across * kWidth), std::size_t{kWidth} - 1);
  const auto row = std::min(static_cast<std::size_t>(upward * kHeight), std::size_t{kHeight} - 1);
  return row * kWidth + column;
}

void CrowdMap::add(const Vec3& point_m, float events) {
  if (const auto cell = cell_of(point_m)) events_[*cell] += events;
}

std::uint16_t CrowdMap::others_at(const Vec3& point_m) const {
  constexpr float kMost = 65535;
  const auto cell = cell_of(point_m);
  return cell ? static_cast<std::uint16_t>(std::clamp(events_[*cell] - 1.0F, 0.0F, kMost)) : std::uint16_t{0};
}

}  // namespace poise::simulation
