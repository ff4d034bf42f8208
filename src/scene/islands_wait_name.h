// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

#include "poise/types.h"

namespace poise::io {

/// The names of IslandsWait in scenes, options and reports, in its order.
inline constexpr std::array<const char*, 3> kIslandsWaitNames{"never", "near_rest", "any"};

inline const char* islands_wait_name(IslandsWait wait) { return kIslandsWaitNames[static_cast<std::size_t>(wait)]; }

}  // namespace poise::io
