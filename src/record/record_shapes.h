// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "poise/scene/scene.h"
#include "record/record.h"

namespace poise::io {

/// The files and resulting hashes of the shapes of a scene, in the order of `shapes`: those of the scene, then those of
/// its tray. Reads every file that the scene names again. Refused: a file that cannot be read.
Result<std::vector<RecordedShape>> recorded_shapes(const Scene& scene, std::span<const ShapePtr> shapes);

/// Checks that the files of a scene are those of its record, before they are loaded. Refused with the file, its
/// recorded and its present content hash.
Status check_files(const Scene& scene, std::span<const RecordedShape> recorded);

/// Checks that the loaded shapes equal those of the record. Refused with the first one that differs.
Status check_shapes(const Scene& scene, std::span<const ShapePtr> shapes, std::span<const RecordedShape> recorded);

}  // namespace poise::io
