// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "poise/scene/scene.h"

namespace poise::io {

struct SceneCheckOptions {
  std::optional<std::uint64_t> bodies;          ///< as SceneRunOptions::bodies
  std::optional<std::uint64_t> seed;            ///< likewise
  std::optional<TreeCacheSettings> tree_cache;  ///< where trees are looked for; none: each would be built
  int threads = 0;                              ///< with which the scene would run, 0 = as many as the machine has
};

/// What a scene would need and what looks wrong, found without building a tree or making a step. Estimates are those of
/// docs/scene-format.md ("What a scene needs"), right within a factor of two or so.
struct SceneCheck {
  std::vector<std::string> errors;    ///< why it cannot run, one line each with file and field
  std::vector<std::string> warnings;  ///< what is probably not meant, likewise
  std::uint64_t bodies = 0;           ///< in the end, static ones and the tray included
  std::uint64_t dynamic_bodies = 0;
  std::uint64_t trees_ready = 0;     ///< meshes whose tree is in the cache
  std::uint64_t trees_to_build = 0;  ///< meshes whose tree must be built
  double tree_cpu_s = 0;             ///< estimate: processor time for building them
  double tree_wall_s = 0;            ///< estimate: on this many threads
  double memory_bytes = 0;           ///< estimate: largest resident memory of `poise run`
  double heap_frame_ms = 0;          ///< estimate: what a frame takes at the least when all bodies lie in a heap
  double pair_ms = 0;                ///< estimate: refining the dearest pair of shapes to the end, on one thread
  double deadline_ms = 0;            ///< the scene's, else its time step
  int threads = 1;
};

/// Looks at a scene that parse_scene accepted. Reads its meshes, trees and the tree cache. Any thread.
SceneCheck check_scene(const Scene& scene, const SceneCheckOptions& options);

}  // namespace poise::io
