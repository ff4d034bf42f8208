// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "app/picture/picture.h"
#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/sphere_tree.h"

namespace poise::io {

/// A tree to draw, and what to write beside its panels; an empty name for none.
struct DrawnTree {
  const SphereTree* tree = nullptr;
  std::string name;
};

struct TreePictureSettings {
  std::uint32_t width_px = 1800;  ///< from 200 to 10000
  Vec3 up = Vec3::UnitZ();        ///< an axis or its opposite: upward in the picture
  /// Towards where the object looks, and whence it is seen: an axis or its opposite, square to `up`. By default where
  /// modellers have it: -y with z upward, z with y upward.
  std::optional<Vec3> front = {};
  Solidity solidity = Solidity::Solid;
  bool dark = false;  ///< on a dark ground
  int threads = 0;    ///< 0 = as many as the machine has; the picture does not depend on it
};

/// Draws a mesh and, beside it, the balls of each level of each tree, all from the same side and to the same scale. A
/// point of a ball has the colour of its distance to the object (protrusion_color), so a leak of a foreign tree shows
/// as well as a bump. Refused: no tree, a tree without nodes, a width out of range, axes that are not square to each
/// other. Any thread.
Result<Image> draw_trees(const TriangleMesh& mesh, std::span<const DrawnTree> trees,
                         const TreePictureSettings& settings);

/// Colour of a point that stands out by this share of the diagonal: from blue (0.1 % and less) over yellow (1 %) to red
/// (10 % and more), even steps for even ratios.
std::array<double, 3> protrusion_color(double share_of_diagonal);

}  // namespace poise::io
