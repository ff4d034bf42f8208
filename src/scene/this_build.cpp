// SPDX-License-Identifier: MIT
// A file of its own, since it is recompiled at every commit.
#include "build_info.h"
#include "scene/made_by.h"

namespace poise::io {

BuildFacts this_build() { return {POISE_BUILD_VERSION, POISE_BUILD_COMMIT, POISE_BUILD_COMPILER, POISE_BUILD_FLAGS}; }

}  // namespace poise::io
