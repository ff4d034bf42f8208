// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

/// A block that slides to a stop on a floor, against v^2 / (2 mu g).
Status sliding_box(Context& context);
Status sliding_balls(Context& context);
/// A block on a slope, against atan(mu).
Status slope_box(Context& context);
Status slope_box_on_box(Context& context);
Status slope_balls(Context& context);
/// A tall box on a rough slope, against atan(width / height).
Status tipping_box(Context& context);
/// A ball that rolls down a slope, against 5/7 g sin(angle).
Status rolling_ball(Context& context);
/// A ball thrown without spin along a floor ends with 5/7 of its speed; one on a slope too steep for rolling slips.
Status skidding_ball(Context& context);

}  // namespace poise::accuracy
