// SPDX-License-Identifier: MIT
// Alone, since it is compiled again at every commit.
#include "build_info.h"
#include "scene/made_by.h"

namespace poise::io {

BuildFacts this_build() { return {POISE_BUILD_VERSION, POISE_BUILD_COMMIT, POISE_BUILD_COMPILER, POISE_BUILD_FLAGS}; }

}  // namespace poise::io
