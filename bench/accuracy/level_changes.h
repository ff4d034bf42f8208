// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

// 60 s of a settled pile whose levels change, and of one at level 0 alone, without and with friction.
Status jacks_change_levels(Context& context);
Status jacks_change_levels_with_friction(Context& context);
Status meshes_change_levels(Context& context);
Status meshes_change_levels_with_friction(Context& context);

}  // namespace poise::accuracy
