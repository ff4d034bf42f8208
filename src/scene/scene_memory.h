// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "poise/scene/scene.h"

/// What a scene's bodies need, known before one of them is made (docs/scene-format.md, "What a scene needs").
namespace poise::io {

inline constexpr double kBaseBytes = 22e6;        ///< the program without a scene
inline constexpr double kBytesOfBody = 8.0e3;     ///< state, contacts, candidates and fronts of a body in a pile
inline constexpr double kBytesOfThread = 0.3e6;   ///< without its fronts
inline constexpr double kBytesOfGenerated = 300;  ///< of a generated body, until it is there
inline constexpr double kBytesOfPair = 2.4e3;     ///< candidates, points and lanes of a pair beyond those of a pile

/// Bodies of a scene, as numbers that are exact but for streams, whose most at once is rounded up.
struct BodyNumbers {
  double at_once = 0;    ///< at most, those of the file and the tray included
  double generated = 0;  ///< in the whole run
};
/// `bodies` as in SceneRunOptions. Any thread.
BodyNumbers body_numbers(const Scene& scene, std::optional<std::uint64_t> bodies);
/// The program, `threads` (0: as many as this process may use) and these bodies, without meshes and trees.
double bodies_bytes(const BodyNumbers& numbers, int threads);

/// Of a limit, the number of candidate pairs that fit into what the bodies leave: WorldSettings::max_pairs, at most
/// `most`. `bodies` as in SceneRunOptions, `threads` as above. Refused, with file, numbers and limit: bodies that leave
/// nothing.
Result<std::uint32_t> pairs_that_fit(const Scene& scene, std::optional<std::uint64_t> bodies, int threads,
                                     std::uint64_t limit_bytes, std::uint32_t most);

}  // namespace poise::io
