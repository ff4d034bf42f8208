// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collision/manifold/manifold_point.h"
#include "parallel/large_pages.h"
#include "solver/contact_point.h"

namespace poise::simulation {

/// Two bodies where they are now. Where b is a plane, `height_m` is that of its surface along its normal.
struct PlacedPair {
  const collision::Pose& a;
  const collision::Pose& b;
  bool plane = false;
  double height_m = 0;
};

/// Fixes a place that is given in the frame of a to the bodies. On a plane the gap becomes that of the plane itself.
solver::ContactPoint keep(const PlacedPair& pair, const collision::ManifoldPoint& manifold_point);

/// Places of one pair: that of its one contact, and where it rests.
inline constexpr std::size_t kPointsOfPair = collision::kMaxManifoldPoints + 1;
inline constexpr std::uint32_t kNoSlot = 0xffffffffU;

/// Places and what they bear, a room for kPlacesOfPair of each pair that has some. A pair keeps its room for as long as
/// it is known, so that what is kept stays where it is. Invariant: a room is either free or one pair's.
struct ContactCache {
  parallel::LargeVector<solver::ContactPoint> points;
  parallel::LargeVector<solver::AccumulatedImpulse> loads;
  std::vector<std::uint32_t> free;

  /// The same for at least `rooms` rooms, without room for new ones being used yet.
  void reserve(std::size_t rooms);
  /// Makes sure that `rooms` more can be had from `take`.
  void reserve_slots(std::size_t rooms);
  /// The n-th of the rooms that make_room made sure of; use_up(count) when all have been taken. Any thread.
  [[nodiscard]] std::uint32_t room(std::size_t n) const { return free[free.size() - 1 - n]; }
  void use_up(std::size_t count) { free.resize(free.size() - count); }
  void give_back(std::uint32_t room) {
    if (room != kNoSlot) free.push_back(room);
  }

  [[nodiscard]] static std::size_t begin(std::uint32_t room) { return room * kPointsOfPair; }
  [[nodiscard]] std::span<solver::ContactPoint> points_of(std::uint32_t room, std::size_t count) {
    return std::span(points).subspan(begin(room), count);
  }
  [[nodiscard]] std::span<solver::AccumulatedImpulse> impulses_of(std::uint32_t room, std::size_t count) {
    return std::span(loads).subspan(begin(room), count);
  }
};

}  // namespace poise::simulation
