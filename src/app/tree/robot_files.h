// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "assets/tree/urdf_robot.h"
#include "poise/mesh.h"
#include "poise/result.h"

namespace poise::app {

/// Where the files of a robot are.
struct RobotFolders {
  std::filesystem::path folder;           ///< of the URDF
  std::span<const std::string> packages;  ///< NAME=FOLDER, for `package://NAME/...`
};

/// The file that a URDF names: a path relative to its folder, `file://` an absolute one, `package://NAME/REST` (or
/// `model://`) REST in the folder of the package: the one that is given, else NAME in the folder of the URDF or in one
/// above it, or such a folder itself if it is called NAME. Refused: a package that is nowhere.
Result<std::filesystem::path> robot_file(const std::string& name, const RobotFolders& folders);

/// All shapes of a link in its frame; each mesh is repaired, then they are put together. Refused with link, line and
/// file.
Result<TriangleMesh> mesh_of_link(const geometry::UrdfLink& link, const RobotFolders& folders);

}  // namespace poise::app
