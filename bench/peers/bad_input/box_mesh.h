// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "poise/types.h"

namespace poise::bench {

/// The corners of a box by its half sides and centre; bit 0, 1 and 2 of a corner's number say on which side of x, y, z
/// it is.
inline std::array<Vec3, 8> box_corners(const Vec3& half_m, const Vec3& center_m) {
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 side((i & 1U) != 0 ? 1 : -1, (i & 2U) != 0 ? 1 : -1, (i & 4U) != 0 ? 1 : -1);
    corners[i] = center_m + half_m.cwiseProduct(side);
  }
  return corners;
}

/// Its triangles, counter-clockwise when seen from outside.
inline constexpr std::array<std::array<std::uint32_t, 3>, 12> kBoxTriangles{{{0, 2, 3},
                                                                             {0, 3, 1},
                                                                             {4, 5, 7},
                                                                             {4, 7, 6},
                                                                             {0, 1, 5},
                                                                             {0, 5, 4},
                                                                             {2, 6, 7},
                                                                             {2, 7, 3},
                                                                             {0, 4, 6},
                                                                             {0, 6, 2},
                                                                             {1, 3, 7},
                                                                             {1, 7, 5}}};

}  // namespace poise::bench
