// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

/// SimBenchmark (Kang and Hwangbo 2018): 7 x 7 elastic balls dropped from 5 m, 20 s; and 6^3 balls falling on each
/// other, 10 s.
Status bouncing_balls(Context& context);
Status falling_cube(Context& context);

// 60 s each, from scene files.
Status stack_of_spheres(Context& context);
Status stack_of_boxes(Context& context);
Status wall_of_bricks(Context& context);
Status arch(Context& context);
Status card_house(Context& context);
Status heavy_on_top(Context& context);
Status chain_of_masses(Context& context);
Status mixed_pile(Context& context);
Status bowl_of_spheres(Context& context);

}  // namespace poise::accuracy
