// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/sphere_tree.h"

namespace poise {

/// The cache of built trees between runs. The library touches the cache only where it is handed these settings.
struct TreeCacheSettings {
  bool on = true;
  std::filesystem::path folder;  ///< empty: default_tree_cache_folder(); made with mode 0700 when it is missing
  std::uint64_t limit_bytes = 1ULL << 30;  ///< of all entries; beyond it those go first that were not used for longest
};

/// What became of a tree that was asked for.
enum class TreeCacheOutcome : std::uint8_t {
  Off,          ///< the cache was not looked at
  Hit,          ///< read from the cache
  Built,        ///< built and stored; a tree larger than the limit is not stored
  Rebuilt,      ///< there was an entry, but a damaged or foreign one: built, and the entry replaced
  NotWritable,  ///< built, but the folder could not be written
};

/// $XDG_CACHE_HOME/poise, else $HOME/.cache/poise; relative values of the two are ignored, as the XDG base directory
/// specification asks. Empty when neither is set. Must not run beside a change of the environment.
std::filesystem::path default_tree_cache_folder();

/// build_sphere_tree, or the same tree, bit for bit, from an earlier call. An entry is named by a 128-bit hash (XXH3)
/// of the mesh, of the options that matter (depth, preset, solidity, seed), of kTreeVersion and of the sources and
/// compiler of the builder, and it holds a checksum; whatever is not exactly such an entry is built anew and replaced,
/// never used. Entries appear whole by renaming, so any number of threads and processes may share a folder. Trouble
/// with the folder is never an error: see TreeCacheOutcome. `evicted`, if given, gets the number of entries that were
/// removed to keep the limit. Any thread. Refused as build_sphere_tree.
Result<SphereTree> cached_sphere_tree(const TriangleMesh& mesh, const TreeBuildOptions& options,
                                      const TreeCacheSettings& settings, TreeCacheOutcome* outcome = nullptr,
                                      std::size_t* evicted = nullptr);

}  // namespace poise
