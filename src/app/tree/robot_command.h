// SPDX-License-Identifier: MIT
#pragma once

#include "app/tree/tree_options.h"

namespace poise::app {

/// `poise tree ROBOT.urdf`: builds and measures the trees of all links, prints a table, and writes the robot with the
/// spheres of a level as its collision shapes. Returns the exit code.
int measure_robot(const TreeOptions& options);

}  // namespace poise::app
