// SPDX-License-Identifier: MIT
#pragma once

#include "frame/refine/refine.h"

namespace poise::simulation {

/// Lists what the frame has shown of its pairs, in their order, for LearnedGains. Of many pairs only every k-th, in
/// turn, so that it takes bounded time. Depends on the levels that completed and not on how they did.
void observe_gains(const RefineInput& input, const CompletedLevels& levels, std::vector<GainObservation>& observed);

}  // namespace poise::simulation
