// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "app/picture/drawn_planes.h"

namespace poise::io {

struct Image;

/// A ring where the viewer of the scene looks: where the gaze meets the first body or plane. Nothing without a camera,
/// and where that point is not before the eye. `samples_across` is the number of the eye's samples a pixel, each way.
void draw_gaze_ring(const DrawnFrame& frame, std::span<const DrawnShape> shapes, std::span<const DrawnPlane> planes,
                    const Eye& eye, int samples_across, Image& image);

/// Below in the picture: scene, frame and time, and what the colours of the bodies mean. An image that is too small
/// for it stays as it is.
void draw_legend(const DrawnFrame& frame, std::span<const DrawnShape> shapes, Image& image);

}  // namespace poise::io
