// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "poise/sphere_tree.h"
#include "poise/types.h"

namespace poise::geometry {

/// The smallest ball that contains all points, exact to rounding. Pivots a support set of at most four points: each
/// step adds the farthest outside point (Gaertner, "Fast and robust smallest enclosing balls", 1999). The radius is the
/// largest distance to a point, so no point is outside by more than the rounding of one distance. Without points, a
/// ball of radius 0 at the origin. Any thread.
Sphere enclosing_ball(std::span<const Vec3> points);

/// A small ball that contains all balls; not exact: within about 1 % of the smallest. Steps toward the farthest ball
/// (Badoiu and Clarkson 2003), then a pattern search. Any thread.
Sphere enclosing_ball_of_balls(std::span<const Sphere> balls);

}  // namespace poise::geometry
