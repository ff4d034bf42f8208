// SPDX-License-Identifier: MIT
#pragma once

#include "scene/import/mjcf_import.h"
#include "scene/import/mjcf_values.h"

namespace poise::io {

/// Notes the attributes of an element that MuJoCo does not know (as of 3.3: a word that is misspelt would be passed
/// over), and those that change motion here in vain. Elements of kinds that are not read have none.
void note_mjcf_attributes(const MjcfView& view, UnmodelledKinds& unmodelled);

}  // namespace poise::io
