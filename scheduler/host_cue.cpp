// SPDX-License-Identifier: MIT
#include "poise/scheduler/host_cue.h"

#include <algorithm>
#include <cmath>

namespace poise::scheduler {

HostFactor host_factor(const HostCue& cue, const PairView& view) {
  if (cue.function == nullptr) return {};
  const double asked = cue.function(view, cue.context);
  if (std::isnan(asked)) return {1.0F, true};
  const double factor = std::clamp(asked, 0.0, kMostHostFactor);
  return {static_cast<float>(factor), factor != asked};
}

}  // namespace poise::scheduler
