// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/process/progress.h"
#include "app/tree/tree_document.h"
#include "app/tree/tree_options.h"
#include "parallel/interrupt.h"
#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/sphere_tree.h"

namespace poise::app {

/// A mesh and its trees, with what was found.
struct TreeWork {
  TriangleMesh mesh;
  std::vector<SphereTree> trees;  ///< beside document.trees
  io::TreeDocument document;
};

/// Reads the mesh, builds or reads the trees and measures them. A refusal names the file; Cancelled after Ctrl-C.
Result<TreeWork> do_tree_work(const TreeOptions& options, Progress& progress, const parallel::Interrupt& interrupt);

/// Builds and measures the tree of a mesh that has no file of its own; messages call it `name`. Refused as above.
Result<TreeWork> do_mesh_work(TriangleMesh mesh, const std::string& name, const TreeOptions& options,
                              Progress& progress, const parallel::Interrupt& interrupt);

/// Builds a tree and measures what that takes. A refusal comes back as the builder says it.
Result<SphereTree> build_measured(const TriangleMesh& mesh, const TreeBuildOptions& options, io::TreeBuildCost& cost);

/// Reads a tree from a .sph file, or a flat set of spheres from the other formats as a tree above it. Refused: a tree
/// that does not reach down to `level`, if one is given. `stop` ends the building of that tree.
Result<SphereTree> read_tree(const std::filesystem::path& file, std::optional<std::uint64_t> level,
                             const std::stop_token& stop = {});

}  // namespace poise::app
