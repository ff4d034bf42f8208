// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/sphere_tree.h"

namespace poise {

/// The cache of built trees between runs. The library uses it only where it is given these settings.
struct TreeCacheSettings {
  bool on = true;
  std::filesystem::path folder;            ///< empty: default_tree_cache_folder(); created with mode 0700 if missing
  std::uint64_t limit_bytes = 1ULL << 30;  ///< of all entries; beyond it the least recently used entries are removed
};

/// How a requested tree was obtained.
enum class TreeCacheOutcome : std::uint8_t {
  Off,          ///< the cache was not used
  Hit,          ///< read from the cache
  Built,        ///< built and stored; a tree larger than the limit is not stored
  Rebuilt,      ///< the entry was damaged or foreign: built, and the entry replaced
  NotWritable,  ///< built, but the folder could not be written
};

/// $XDG_CACHE_HOME/poise, else $HOME/.cache/poise. Relative values of the two variables are ignored, as the XDG base
/// directory specification requires. Empty if neither is set. Any thread, but not while another thread changes the
/// environment.
std::filesystem::path default_tree_cache_folder();

/// Returns the tree of build_sphere_tree, or the same tree, bit for bit, from the cache. An entry is named by a 128-bit
/// hash (XXH3) of the mesh, the options that affect the tree (depth, preset, solidity, seed), kTreeVersion, and the
/// sources and compiler of the builder. It holds a checksum; an entry that does not match is rebuilt and replaced,
/// never used. Entries are written to a temporary file and renamed, so any number of threads and processes may share a
/// folder. A folder that cannot be used is not an error: see TreeCacheOutcome. `outcome`, if given, receives how the
/// tree was obtained; `evicted` the number of entries that were removed to respect the limit. Any thread. Refused as
/// build_sphere_tree.
Result<SphereTree> cached_sphere_tree(const TriangleMesh& mesh, const TreeBuildOptions& options,
                                      const TreeCacheSettings& settings, TreeCacheOutcome* outcome = nullptr,
                                      std::size_t* evicted = nullptr);

}  // namespace poise
