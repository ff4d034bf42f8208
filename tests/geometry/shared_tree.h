// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>

#include "poise/assets/tree_cache.h"

namespace poise::test {

/// A tree of a mesh as build_sphere_tree makes it, kept between tests in the folder that POISE_TREE_CACHE names, if it
/// names one.
inline SphereTree shared_tree(const TriangleMesh& mesh, Level depth) {
  const char* folder = std::getenv("POISE_TREE_CACHE");
  TreeCacheSettings settings;
  settings.on = folder != nullptr;
  if (settings.on) settings.folder = folder;
  return cached_sphere_tree(mesh, {.depth = depth, .preset = TreePreset::Fast}, settings).value();
}

}  // namespace poise::test
