// SPDX-License-Identifier: MIT
#pragma once

#include "poise/shape.h"

namespace poise::collision {

/// The smallest side of the box around a shape in its principal axes, in metres; of a sheet, which has none, a
/// twentieth of its bounding radius. Infinite for a plane. A ball's is its diameter. Any thread.
double least_extent_m(const Shape& shape);

}  // namespace poise::collision
