// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "poise/assets/tree_cache.h"
#include "poise/result.h"

namespace poise::app {

/// Where a command keeps built trees, as the command line says it.
struct TreeCacheOptions {
  std::optional<std::string> folder;
  bool off = false;
};

/// Declares `--tree-cache DIR` and `--no-tree-cache`.
void add_tree_cache_options(CLI::App& command, TreeCacheOptions& options);

/// The settings by the command line, else by POISE_TREE_CACHE (a folder; `off` or nothing switches the cache off), else
/// the default folder. Refused: both options at once, an empty folder.
Result<TreeCacheSettings> tree_cache_settings(const TreeCacheOptions& options);

/// A line for the standard error where trees could not be kept.
std::string tree_cache_warning(const TreeCacheSettings& settings);

}  // namespace poise::app
