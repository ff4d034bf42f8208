// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "poise/sphere_tree.h"
#include "poise/types.h"

// The shapes of all links of a URDF robot, and the robot with other shapes. Joints, masses and everything else are left
// to those who use the robot. Refusals name the line and have no file.
namespace poise::geometry {

enum class UrdfSolid : std::uint8_t {
  Mesh,
  Box,       ///< size_m: edges
  Cylinder,  ///< size_m: radius, length, 0; along z
  Sphere,    ///< size_m: radius, 0, 0
};

/// One shape of a link, in the frame of the link.
struct UrdfPart {
  UrdfSolid solid = UrdfSolid::Mesh;
  std::string file;           ///< of a mesh, as written: a path, `file://...` or `package://NAME/...`
  Vec3 scale = Vec3::Ones();  ///< of a mesh: metres per unit of the file, negative for mirrored; no component is 0
  Vec3 size_m = Vec3::Zero();
  Vec3 position_m = Vec3::Zero();
  Mat3 rotation = Mat3::Identity();
  int line = 0;
};

struct UrdfLink {
  std::string name;
  bool from_visual = false;  ///< it has no collision shape, so that these are its visual ones
  std::vector<UrdfPart> parts;
  /// Whether every collision shape is a sphere already.
  [[nodiscard]] bool only_spheres() const;
};

/// All links in the order of the file, those without a shape too. Refused: what is no URDF, xacro, links without a name
/// of their own, shapes other than those above, numbers that are no lengths.
Result<std::vector<UrdfLink>> urdf_links(const std::string& text);

/// The text with the collision shapes of links replaced by spheres, in the order of urdf_links(text); links without a
/// value stay as they are, as does every other byte. Refused: what urdf_links refuses.
Result<std::string> with_collision_spheres(const std::string& text,
                                           std::span<const std::optional<std::vector<Sphere>>> spheres);

/// `roll pitch yaw` of URDF: about the fixed axes x, then y, then z.
Mat3 rotation_of_rpy(const Vec3& rpy_rad);

}  // namespace poise::geometry
