// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "poise/step.h"

namespace poise::simulation {

/// A stage of a frame by the name that reports give it.
struct StageMember {
  const char* name;
  Nanoseconds StageTimes::*time;
};

/// In the order in which they happen.
inline constexpr std::array<StageMember, 8> kStages{{{"predict", &StageTimes::predict},
                                                     {"broad_phase", &StageTimes::broad_phase},
                                                     {"coarse", &StageTimes::coarse},
                                                     {"refine", &StageTimes::refine},
                                                     {"manifolds", &StageTimes::manifolds},
                                                     {"solve", &StageTimes::solve},
                                                     {"integrate", &StageTimes::integrate},
                                                     {"publish", &StageTimes::publish}}};

}  // namespace poise::simulation
