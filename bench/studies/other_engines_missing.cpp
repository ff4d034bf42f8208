// SPDX-License-Identifier: MIT
#include "studies/other_engines.h"

namespace poise::app {

// Replaces other_engines.cpp where libbullet-dev or libode-dev is not installed.
Result<std::vector<bench::Engine>> other_engines(const Scene&, std::uint64_t) { return std::vector<bench::Engine>(); }

}  // namespace poise::app
