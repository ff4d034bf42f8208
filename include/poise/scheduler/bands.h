// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace poise::scheduler {

/// Number of priority bands; band kBands - 1 is served first. PriorityBands and all functions that return a band use
/// this constant.
inline constexpr std::uint32_t kBands = 256;

/// The band of a score in [0, 1], in bands of equal width. The result is below kBands, monotone in the score, and 0 for
/// a score that is NaN or not positive. Any thread.
std::uint32_t linear_band(double score);

/// The band of a positive score of any unit, with four bands an octave. Band 0 begins at 2^lowest_octave and the last
/// band ends at 2^(lowest_octave + 64); scores outside belong to the nearest band. The result is below kBands, monotone
/// in the score, and 0 for a score that is NaN or not positive. Any thread.
std::uint32_t octave_band(double score, double lowest_octave = -32.0);

}  // namespace poise::scheduler
