// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

/// Numbers that are not finite, masses of zero and the like, through every call of the API that takes numbers, and
/// through a scene.
Status bad_states(Context& context);

}  // namespace poise::accuracy
