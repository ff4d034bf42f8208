// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>

#include "arguments.h"
#include "poise/assets/tree_cache.h"
#include "poise/shape.h"

namespace poise::python {

/// A shape that bodies share.
struct ShapeValue {
  ShapePtr shape;
};

/// Where trees are cached: None for the environment's POISE_TREE_CACHE, else the user's cache; False for nowhere; else
/// a folder.
std::optional<TreeCacheSettings> tree_cache_of(const py::object& given);

/// The path that a str or os.PathLike means.
std::filesystem::path path_of(const py::object& given);

void bind_shapes(py::module_& module);

}  // namespace poise::python
