// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

// A settled pile for 60 s with changing levels, and one at level 0 only, without and with friction.
Status jacks_change_levels(Context& context);
Status jacks_change_levels_with_friction(Context& context);
Status meshes_change_levels(Context& context);
Status meshes_change_levels_with_friction(Context& context);

}  // namespace poise::accuracy
