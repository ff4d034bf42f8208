// SPDX-License-Identifier: MIT
#include "app/options/tree_cache_options.h"

#include <cstdlib>
#include <string_view>

namespace poise::app {

void add_tree_cache_options(CLI::App& command, TreeCacheOptions& options) {
  command
      .add_option("--tree-cache", options.folder,
                  "Keep built sphere trees in this folder (default: POISE_TREE_CACHE, else poise in the user's cache)")
      ->type_name("DIR");
  command.add_flag("--no-tree-cache", options.off, "Build every sphere tree anew and keep none");
}

Result<TreeCacheSettings> tree_cache_settings(const TreeCacheOptions& options) {
  if (options.folder && options.off) return bad_input("--tree-cache has no meaning with --no-tree-cache");
  if (options.folder && options.folder->empty()) return bad_input("--tree-cache must not be empty");
  TreeCacheSettings settings;
  settings.on = !options.off;
  if (options.folder) {
    settings.folder = *options.folder;
  } else if (const char* value = std::getenv("POISE_TREE_CACHE"); value != nullptr) {
    const std::string_view text = value;
    if (text.empty() || text == "off") {
      settings.on = false;
    } else {
      settings.folder = text;
    }
  }
  return settings;
}

std::string tree_cache_warning(const TreeCacheSettings& settings) {
  const std::filesystem::path folder = settings.folder.empty() ? default_tree_cache_folder() : settings.folder;
  if (folder.empty())
    return "sphere trees are not kept: neither XDG_CACHE_HOME nor HOME is set (--no-tree-cache is silent)";
  return "sphere trees are not kept: " + folder.string() + " cannot be written (--no-tree-cache is silent)";
}

}  // namespace poise::app
