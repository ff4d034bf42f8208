// SPDX-License-Identifier: MIT
#pragma once

#include "poise/result.h"
#include "scene/import/mjcf_document.h"
#include "scene/import/mjcf_geom.h"
#include "scene/import/mjcf_import.h"
#include "scene/import/mjcf_values.h"
#include "scene/import/scene_draft.h"

namespace poise::io {

/// The class that an element names, else `otherwise`, else main. Refused: a class that does not exist.
Result<const MjcfClass*> mjcf_class_of(const MjcfDocument& document, const MjcfDocument::Element& element,
                                       const MjcfClasses& classes, const MjcfClass* otherwise);

/// Reads the bodies of all <worldbody>. A body with a free joint becomes one dynamic body with all that is in it; a
/// geom of any other body becomes a static body.
Status read_mjcf_bodies(const MjcfDocument& document, const MjcfClasses& classes, const MjcfSettings& settings,
                        UnmodelledKinds& unmodelled, SceneDraft& draft);

}  // namespace poise::io
