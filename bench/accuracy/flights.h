// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

/// Constant gravity, against x0 + v t + g t^2 / 2.
Status free_flight(Context& context);
/// A free body with the inertia (1, 2, 3) that rotates about its middle axis.
Status spinning_top(Context& context);

}  // namespace poise::accuracy
