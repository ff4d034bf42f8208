// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "poise/sphere_tree.h"

namespace poise::geometry {

/// Why a tree that is given as data cannot be used, as one line with the array, the number and the rule: no node,
/// arrays too short for the nodes and their padding, children that are not the nodes of the next level in order,
/// numbers out of range. Empty for a tree that is as SphereTree says; coverage is not looked at.
std::string why_not_tree(const SphereTree& tree);

}  // namespace poise::geometry
