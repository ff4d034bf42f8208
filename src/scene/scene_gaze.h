// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include "poise/scene/scene.h"

namespace poise::io {

/// Where the viewer of a scene looks at a time, in pixels; empty: at the centre of the image. The file of a recorded
/// gaze must have been read.
std::optional<std::array<double, 2>> gaze_at(const Scene& scene, double time_s);

/// A recorded gaze from a file, as the command line names it: it stays at each point until the next. Refused as
/// read_gaze.
Result<SceneGaze> read_gaze_file(const std::filesystem::path& file, const std::array<double, 2>& resolution_px);

}  // namespace poise::io
