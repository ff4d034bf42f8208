// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "poise/scene/scene.h"
#include "record/record.h"

namespace poise::io {

/// What the shapes of a scene came of and came to, in the order of `shapes`: those of the scene, then those of its
/// tray. Reads every file that the scene names again. Refused: one that cannot be read.
Result<std::vector<RecordedShape>> recorded_shapes(const Scene& scene, std::span<const ShapePtr> shapes);

/// Are the files of a scene those of its record? For before they are loaded. Refused with the file, what it had and
/// what it has.
Status check_files(const Scene& scene, std::span<const RecordedShape> recorded);

/// Did the shapes come out as in the record? Refused with the first that did not.
Status check_shapes(const Scene& scene, std::span<const ShapePtr> shapes, std::span<const RecordedShape> recorded);

}  // namespace poise::io
