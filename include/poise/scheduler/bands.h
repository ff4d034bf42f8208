// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace poise::scheduler {

/// Number of priority bands, of which kBands - 1 is served first. The only definition: PriorityBands and all functions
/// that give a band use it.
inline constexpr std::uint32_t kBands = 256;

/// The band of a score in [0, 1], bands of equal width. Always below kBands; 0 for a score that is NaN or not positive.
/// Monotone. Any thread.
std::uint32_t linear_band(double score);

/// The band of a positive score of any unit, four bands an octave: 2^lowest_octave begins band 0, 2^(lowest_octave +
/// 64) ends the last one, and scores beyond either belong to the band at that end. Always below kBands; 0 for a score
/// that is NaN or not positive. Monotone. Any thread.
std::uint32_t octave_band(double score, double lowest_octave = -32.0);

}  // namespace poise::scheduler
