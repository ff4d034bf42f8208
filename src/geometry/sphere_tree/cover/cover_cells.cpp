// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/cover/cover_cells.h"

#include <algorithm>
#include <cmath>

namespace poise::geometry {
namespace {

/// Bound of the single-precision error of a distance of at most one unit.
constexpr float kRounding = 3e-7F;

}  // namespace

CoverCells::CoverCells(const SolidCells& cells, const CoverFrame& frame) : begin(cells.begin) {
  for (const Vec3& p : cells.points_m) points.add(frame.to(p));
  points.resize(cells.points_m.size() + kReadBeyond);
  for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
    Vec3f low = points.at(begin[cell]);
    Vec3f high = low;
    for (std::size_t i = begin[cell] + 1; i < begin[cell + 1]; ++i) {
      low = low.cwiseMin(points.at(i));
      high = high.cwiseMax(points.at(i));
    }
    middles.add(0.5F * (low + high));
    reach.push_back(reach_from(cell, middles.at(cell)));
  }
}

float CoverCells::reach_from(std::uint32_t cell, const Vec3f& place) const {
  return std::sqrt(largest_squared_distance(points, begin[cell], begin[cell + 1], place));
}

bool CoverCells::within(std::uint32_t cell, const Vec3f& center, float radius) const {
  const float square = (middles.at(cell) - center).squaredNorm();
  if (square > radius * radius) return false;
  if (std::sqrt(square) + reach[cell] <= radius) return true;
  return reach_from(cell, center) <= radius;
}

void CellSet::gather(const CoverCells& cells, const std::vector<std::uint32_t>& ids) {
  ids_ = ids;
  middles_.resize(ids.size());
  const std::size_t room = ids.size() + kReadBeyond;
  if (reach_.size() < room) {
    reach_.resize(room);
    distances_.resize(room);
    far_.resize(room);
  }
  largest_reach_ = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const std::uint32_t cell = ids[i];
    middles_.x[i] = cells.middles.x[cell];
    middles_.y[i] = cells.middles.y[cell];
    middles_.z[i] = cells.middles.z[cell];
    reach_[i] = cells.reach[cell];
    largest_reach_ = std::max(largest_reach_, cells.reach[cell]);
  }
}

float CellSet::radius_about(const CoverCells& cells, const Vec3f& center, float limit) {
  if (ids_.empty()) return 0;
  const float most = squared_distances(middles_, center, distances_.data());
  // Some point of a cell is at least this far, since its middle is within its reach of all of them.
  const float sure = std::sqrt(most) - largest_reach_;
  if (sure > limit) return sure;
  const auto farthest =
      static_cast<std::size_t>(std::find(distances_.begin(), distances_.end(), most) - distances_.begin());
  float radius = cells.reach_from(ids_[farthest], center) + kRounding;
  if (radius > limit) return radius;
  float least = std::max(0.0F, radius - largest_reach_);
  // The radius only grows, so what is within it now stays within it.
  const std::size_t found = balls_beyond(distances_.data(), reach_.data(), ids_.size(), radius, far_.data());
  for (std::size_t k = 0; k < found; ++k) {
    const std::uint32_t i = far_[k];
    if (distances_[i] < least * least || std::sqrt(distances_[i]) + reach_[i] <= radius) continue;
    const float reach = cells.reach_from(ids_[i], center) + kRounding;
    if (reach <= radius) continue;
    if (reach > limit) return reach;
    radius = reach;
    least = std::max(0.0F, radius - largest_reach_);
  }
  return radius;
}

}  // namespace poise::geometry
