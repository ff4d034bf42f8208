// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "peers/engine.h"

namespace poise::app {

/// Other engines with the bodies of a scene, at its start; none where they are not built in. Refused: scenes that they
/// cannot have, where they are.
Result<std::vector<bench::Engine>> other_engines(const Scene& scene, std::uint64_t bodies);

}  // namespace poise::app
