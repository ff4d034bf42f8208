// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

/// Two spheres against the closed form, e from 0 to 1: head-on from a distance, and oblique from contact.
Status two_spheres(Context& context);
/// Five equal balls in a row, e = 1, hit by one of them (Newton's cradle).
Status five_balls(Context& context);
/// Momenta of a free cloud of colliding bodies at every level, e 0 and 1, without and with friction.
Status cloud_momenta(Context& context);
/// Kinetic energy of single impacts of two bodies at every level, e = 1.
Status impact_energy(Context& context);
/// A ball dropped from 1 m, e = 0.5.
Status dropped_ball(Context& context);

}  // namespace poise::accuracy
