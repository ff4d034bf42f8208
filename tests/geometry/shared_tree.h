// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>

#include "poise/assets/tree_cache.h"

namespace poise::test {

/// The folder in POISE_TREE_CACHE, where tests share trees; off if it is not set.
inline TreeCacheSettings shared_trees() {
  const char* folder = std::getenv("POISE_TREE_CACHE");
  TreeCacheSettings settings;
  settings.on = folder != nullptr;
  if (settings.on) settings.folder = folder;
  return settings;
}

/// A tree of a mesh by build_sphere_tree, cached in that folder.
inline SphereTree shared_tree(const TriangleMesh& mesh, Level depth) {
  return cached_sphere_tree(mesh, {.depth = depth, .preset = TreePreset::Fast}, shared_trees()).value();
}

}  // namespace poise::test
