// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "capture/export/body_tracks.h"

namespace poise::capture {

/// A binary glTF 2.0 (.glb) of the chosen frames: a mesh for each shape, a node for each body that is in one of them,
/// and with more than one frame an animation of positions and orientations. A body that is not in all of them has scale
/// 0 before and after. The camera is a node too. glTF has +y up, so the node `scene` above all others turns the z axis
/// of the run there.
///
/// Frames are read until `goes_on` (empty: always) says no; then what is made is of no use.
Result<std::string> gltf_bytes(CaptureReader& reader, const FrameChoice& choice,
                               const std::function<bool()>& goes_on = {});

}  // namespace poise::capture
