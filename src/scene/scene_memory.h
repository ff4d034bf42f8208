// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "poise/scene/scene.h"

/// What a scene's bodies need, known before one of them is made (docs/scene-format.md, "What a scene needs").
namespace poise::io {

inline constexpr double kBaseBytes = 22e6;        ///< the program without a scene
inline constexpr double kBytesOfBody = 7.0e3;     ///< state, contacts, candidates and fronts of a body in a pile
inline constexpr double kBytesOfThread = 0.3e6;   ///< without its fronts
inline constexpr double kBytesOfGenerated = 250;  ///< of a generated body before it comes
inline constexpr double kBytesOfPair = 2.4e3;     ///< candidates, points and lanes of a pair beyond those of a pile

/// Of a limit, the number of candidate pairs that fit into what the bodies leave: WorldSettings::max_pairs, at most
/// `most`. `bodies` as in SceneRunOptions. Refused, with file and field: bodies that leave nothing.
Result<std::uint32_t> pairs_that_fit(const Scene& scene, std::optional<std::uint64_t> bodies, int threads,
                                     std::uint64_t limit_bytes, std::uint32_t most);

}  // namespace poise::io
