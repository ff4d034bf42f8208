// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "poise/assets/tree_formats.h"
#include "poise/result.h"
#include "poise/sphere_tree.h"
#include "poise/types.h"

namespace poise::app {

/// What one call of `poise tree` is asked for.
enum class TreeTask {
  Measure,  ///< a tree that is built, or read, is measured against a mesh, and perhaps compared with another
  Convert,  ///< a tree from a file is written in another format, without a mesh
  Robot,    ///< trees of all links of a URDF robot
  Inspect,  ///< meshes are assessed, and no tree is built
};

/// The command line of `poise tree`, as it was given.
struct TreeOptions {
  std::vector<std::string> meshes;
  std::vector<std::string> packages;  ///< of a robot: NAME=FOLDER
  std::string tree, compare, output, json, picture, picture_dark;
  std::optional<std::string> preset, up, front;
  std::optional<std::uint64_t> depth, threads, seed, samples, level;
  std::optional<double> scale;
  bool shell = false;
  bool report = false;
  bool require_coverage = false;
  bool quiet = false;
};

/// Declares the options; `options` must outlive the parse.
void add_tree_options(CLI::App& command, TreeOptions& options);

TreeTask task_of(const TreeOptions& options);
/// Whether a picture is asked for.
bool draws(const TreeOptions& options);

/// Refuses options that have no meaning together, with both their names.
Status check_tree_options(const TreeOptions& options);

/// The axis that is upward in the picture: as given, else what the mesh's format says, else z.
std::string up_of(const TreeOptions& options);

/// The unit vector of x, y, z, -x, -y or -z.
Vec3 axis_of(const std::string& name);

TreePreset preset_of(const std::string& name);

}  // namespace poise::app
