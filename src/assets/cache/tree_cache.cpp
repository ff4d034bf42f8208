// SPDX-License-Identifier: MIT
#include "poise/assets/tree_cache.h"

#include <cstdlib>
#include <exception>
#include <string>
#include <utility>

#include "assets/cache/tree_cache_entry.h"
#include "assets/cache/tree_cache_folder.h"

namespace poise {
namespace {

namespace fs = std::filesystem;
using namespace geometry;

/// The absolute path in an environment variable, else empty.
fs::path environment_folder(const char* name) {
  const char* value = std::getenv(name);
  fs::path folder = value != nullptr ? fs::path(value) : fs::path();
  return folder.is_absolute() ? folder : fs::path();
}

struct Looked {
  std::optional<SphereTree> tree;
  bool damaged = false;  ///< there was a file, but no valid entry
};

Looked look_up(const fs::path& file, const TreeKey& key) {
  Looked looked;
  std::string bytes;
  const EntryRead read = read_entry(file, kMostEntryBytes, bytes);
  if (read == EntryRead::Found) looked.tree = entry_tree(bytes, key);
  looked.damaged = read != EntryRead::Missing && !looked.tree;
  return looked;
}

}  // namespace

fs::path default_tree_cache_folder() {
  const fs::path base = environment_folder("XDG_CACHE_HOME");
  if (!base.empty()) return base / "poise";
  const fs::path home = environment_folder("HOME");
  return home.empty() ? fs::path() : home / ".cache" / "poise";
}

Result<SphereTree> cached_sphere_tree(const TriangleMesh& mesh, const TreeBuildOptions& options,
                                      const TreeCacheSettings& settings, TreeCacheOutcome* outcome,
                                      std::size_t* evicted) {
  TreeCacheOutcome ignored_outcome{};
  std::size_t ignored_count = 0;
  TreeCacheOutcome& became = outcome != nullptr ? *outcome : ignored_outcome;
  std::size_t& removed = evicted != nullptr ? *evicted : ignored_count;
  became = TreeCacheOutcome::Off;
  removed = 0;
  if (!settings.on) return build_sphere_tree(mesh, options);
  try {
    const fs::path folder = settings.folder.empty() ? default_tree_cache_folder() : settings.folder;
    const TreeKey key = tree_key(mesh, options);
    const fs::path file = folder / (key_text(key) + ".poisetree");
    Looked looked = folder.empty() ? Looked{} : look_up(file, key);
    if (looked.tree) {
      became = TreeCacheOutcome::Hit;
      touch_entry(file);
      if (options.progress) options.progress(1);
      return std::move(*looked.tree);
    }
    Result<SphereTree> tree = build_sphere_tree(mesh, options);
    if (!tree) return tree;
    became = looked.damaged ? TreeCacheOutcome::Rebuilt : TreeCacheOutcome::Built;
    const std::string bytes = entry_bytes(tree.value(), key);
    if (bytes.size() > settings.limit_bytes) return tree;
    if (folder.empty() || !write_entry(file, bytes)) {
      became = TreeCacheOutcome::NotWritable;
      return tree;
    }
    removed = keep_limit(file, settings.limit_bytes);
    return tree;
  } catch (const std::exception&) {
    // The path could not be built or memory is short: the tree itself may still be built.
    became = TreeCacheOutcome::NotWritable;
  }
  return build_sphere_tree(mesh, options);
}

}  // namespace poise
