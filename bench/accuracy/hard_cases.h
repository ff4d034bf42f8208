// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

// Each case must stay finite and sane: no body lost, energy not above the start plus the work done, and low speeds in
// the next hundred frames.
Status coinciding_centres(Context& context);
Status equal_positions(Context& context);
Status mass_ratios(Context& context);
Status random_masses(Context& context);
Status needles_and_plates(Context& context);
Status one_km_per_s(Context& context);
Status far_from_origin(Context& context);
Status fast_spins(Context& context);
Status overlapping_spawn(Context& context);
Status time_steps(Context& context);
Status flipping_levels(Context& context);
/// A ball of 0.05 m at 500 m/s against a plate of 0.02 m. Adds no row if the engine has no backtracking.
Status bullet(Context& context);

}  // namespace poise::accuracy
