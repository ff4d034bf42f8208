// SPDX-License-Identifier: MIT
#include "poise/scheduler/bands.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "math/functions.h"

namespace poise::scheduler {
namespace {

constexpr double kTop = kBands - 1;

/// Four times the octave of a positive normal score, rounded down. Comparisons take a third of the time of a logarithm.
double quarter_octave(double score) {
  const auto bits = std::bit_cast<std::uint64_t>(score);
  const auto octave = static_cast<double>(bits >> 52) - 1023;
  const double within = std::bit_cast<double>((bits & 0xfffffffffffffULL) | 0x3ff0000000000000ULL);  // from 1 to 2
  constexpr std::array<double, 3> kQuarters{1.1892071150027210667, 1.4142135623730950488, 1.6817928305074290861};
  return 4 * octave + (within >= kQuarters[0]) + (within >= kQuarters[1]) + (within >= kQuarters[2]);
}

}  // namespace

std::uint32_t linear_band(double score) {
  if (!(score > 0)) return 0;
  return static_cast<std::uint32_t>(std::clamp(score * kBands, 0.0, kTop));
}

std::uint32_t octave_band(double score, double lowest_octave) {
  if (!(score > 0)) return 0;
  const double lowest = 4 * lowest_octave;
  const double band = lowest == std::floor(lowest) && std::isnormal(score) ? quarter_octave(score) - lowest
                                                                           : 4.0 * (math::log2(score) - lowest_octave);
  return static_cast<std::uint32_t>(std::clamp(band, 0.0, kTop));
}

}  // namespace poise::scheduler
