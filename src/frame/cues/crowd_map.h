// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "frame/view_cues.h"

namespace poise::simulation {

/// Measures the cue *crowding*: how many events there are in each cell of the image.
class CrowdMap {
 public:
  /// Chosen: about 3 degrees in a view of 90 by 50.
  static constexpr int kWidth = 32, kHeight = 18;

  void begin(const ViewQuery& view_query);
  /// Counts an event at a point, which stands for `events`. Nothing outside the image.
  void add(const Vec3& point_m, float events);
  /// Events in the cell of a point, but for one: its own. 0 outside the image.
  [[nodiscard]] std::uint16_t others_at(const Vec3& point_m) const;

 private:
  [[nodiscard]] std::optional<std::size_t> cell_of(const Vec3& point_m) const;
  ViewQuery view_query_{View{}};
  std::array<float, std::size_t{kWidth} * kHeight> events_{};
};

}  // namespace poise::simulation
