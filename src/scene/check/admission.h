// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/check/placed_bodies.h"
#include "scene/generators.h"

namespace poise::io {

/// What a World would refuse of a scene that was read: its settings, materials and bodies. Of bodies that are generated
/// the first `most_generated` are tried, and the first refusal is told. `shapes` as long as the scene's list.
std::vector<std::string> refused_by_world(const Scene& scene, std::span<const CheckedShape> shapes,
                                          std::span<const GeneratedBody> generated, std::size_t most_generated);

}  // namespace poise::io
