// SPDX-License-Identifier: MIT
#include "poise/scheduler/bands.h"

#include <algorithm>
#include <cmath>

namespace poise::scheduler {
namespace {

constexpr double kTop = kBands - 1;

}  // namespace

std::uint32_t linear_band(double score) {
  if (!(score > 0)) return 0;
  return static_cast<std::uint32_t>(std::clamp(score * kBands, 0.0, kTop));
}

std::uint32_t octave_band(double score, double lowest_octave) {
  if (!(score > 0)) return 0;
  return static_cast<std::uint32_t>(std::clamp(4.0 * (std::log2(score) - lowest_octave), 0.0, kTop));
}

}  // namespace poise::scheduler
