// SPDX-License-Identifier: MIT
#pragma once

#include "poise/scene/scene.h"

namespace poise::io {

/// Whether a Scene can be run as it is: a caller may have changed what read_scene has checked. Looks at the time step,
/// at counts, and at what names an item of a list; numbers of bodies and materials are the World's to refuse. Refused
/// with the scene's source, field, value and rule.
Status check_scene_data(const Scene& scene);

}  // namespace poise::io
