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
  std::optional<TreeCacheSettings> tree_cache;  ///< the cache in which trees are searched; empty: every tree counts as
                                                ///< not built
  std::optional<std::uint64_t> max_memory_bytes;  ///< likewise; the meshes and trees are not counted here
  int threads = 0;                                ///< number of the run, 0 = as many as the machine has
};

/// Requirements and probable mistakes of a scene, found without building a tree or making a step. The estimates are
/// those of docs/scene-format.md ("What a scene needs"), accurate to about a factor of two.
struct SceneCheck {
  std::vector<std::string> errors;    ///< why the scene cannot run, one line each with file and field
  std::vector<std::string> warnings;  ///< probable mistakes, likewise
  std::uint64_t bodies = 0;           ///< most at a time, static ones and the tray included
  std::uint64_t dynamic_bodies = 0;
  std::uint64_t trees_ready = 0;     ///< meshes whose tree is in the cache
  std::uint64_t trees_to_build = 0;  ///< meshes whose tree must be built
  double tree_cpu_s = 0;             ///< estimate: processor time for building them
  double tree_wall_s = 0;            ///< estimate: on this many threads
  double memory_bytes = 0;           ///< estimate: largest resident memory of `poise run`
  double heap_frame_ms = 0;          ///< estimate: least time of a frame when all bodies lie in a pile
  double pair_ms = 0;                ///< estimate: refining the most expensive pair of shapes to its end, on one thread
  double deadline_ms = 0;            ///< the scene's deadline, or else its time step
  int threads = 1;
};

/// Checks a scene that parse_scene accepted. Reads its meshes, trees and the tree cache. Any thread.
SceneCheck check_scene(const Scene& scene, const SceneCheckOptions& options);

}  // namespace poise::io
