// SPDX-License-Identifier: MIT
#include "geometry/cover_atoms.h"

#include <algorithm>
#include <cmath>

namespace poise::geometry {
namespace {

/// What single precision may be wrong by in a distance of at most the unit.
constexpr float kRounding = 3e-7F;

}  // namespace

CoverAtoms::CoverAtoms(const SolidAtoms& atoms, const CoverFrame& frame) : begin(atoms.begin) {
  points.reserve(atoms.points_m.size());
  for (const Vec3& p : atoms.points_m) points.push_back(frame.to(p));
  for (std::uint32_t atom = 0; atom < atoms.size(); ++atom) {
    Vec3f low = points[begin[atom]];
    Vec3f high = low;
    for (std::size_t i = begin[atom] + 1; i < begin[atom + 1]; ++i) {
      low = low.cwiseMin(points[i]);
      high = high.cwiseMax(points[i]);
    }
    middles.add(0.5F * (low + high));
    reach.push_back(reach_from(atom, middles.at(atom)));
  }
}

float CoverAtoms::reach_from(std::uint32_t atom, const Vec3f& place) const {
  float largest = 0;
  for (std::size_t i = begin[atom]; i < begin[atom + 1]; ++i)
    largest = std::max(largest, (points[i] - place).squaredNorm());
  return std::sqrt(largest);
}

bool CoverAtoms::within(std::uint32_t atom, const Vec3f& center, float radius) const {
  const float square = (middles.at(atom) - center).squaredNorm();
  if (square > radius * radius) return false;
  if (std::sqrt(square) + reach[atom] <= radius) return true;
  return reach_from(atom, center) <= radius;
}

void AtomSet::gather(const CoverAtoms& atoms, const std::vector<std::uint32_t>& ids) {
  middles_.clear();
  reach_.clear();
  ids_ = ids;
  largest_reach_ = 0;
  for (const std::uint32_t atom : ids) {
    middles_.add(atoms.middles.at(atom));
    reach_.push_back(atoms.reach[atom]);
    largest_reach_ = std::max(largest_reach_, atoms.reach[atom]);
  }
  if (distances_.size() < ids.size()) distances_.resize(ids.size());
}

float AtomSet::radius_about(const CoverAtoms& atoms, const Vec3f& center, float limit) {
  if (ids_.empty()) return 0;
  const float most = squared_distances(middles_, center, distances_.data());
  // Some point of an atom is at least this far: its middle is within its reach of all of them.
  const float sure = std::sqrt(most) - largest_reach_;
  if (sure > limit) return sure;
  const auto farthest =
      static_cast<std::size_t>(std::find(distances_.begin(), distances_.end(), most) - distances_.begin());
  float radius = atoms.reach_from(ids_[farthest], center) + kRounding;
  if (radius > limit) return radius;
  float least = std::max(0.0F, radius - largest_reach_);
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (distances_[i] < least * least || std::sqrt(distances_[i]) + reach_[i] <= radius) continue;
    const float reach = atoms.reach_from(ids_[i], center) + kRounding;
    if (reach <= radius) continue;
    if (reach > limit) return reach;
    radius = reach;
    least = std::max(0.0F, radius - largest_reach_);
  }
  return radius;
}

}  // namespace poise::geometry
