// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "poise/sphere_tree.h"

namespace poise::geometry {

/// Why tree_of_spheres refuses these spheres, as one line; empty if it does not.
std::string why_not_spheres(std::span<const Sphere> spheres);

/// tree_of_spheres of spheres that are not refused, wherever they were moved since. Cancelled if it was stopped.
Result<SphereTree> union_tree(std::span<const Sphere> spheres, const UnionTreeOptions& options);

}  // namespace poise::geometry
