// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "solver/contacts/contact_lanes.h"

/// The kinetic energy of EnergyGuard, several bodies at a time, with the bits of one after another.
namespace poise::solver {

/// Up to eight bodies, a figure an array, world frame.
struct alignas(64) BodyEnergies {
  double kg[kLanes] = {};
  double inertia_kgm2[3][3][kLanes] = {};                           ///< by columns
  double velocity_mps[3][kLanes] = {}, spin_radps[3][kLanes] = {};  ///< at the start of the step
  std::uint32_t name[kLanes] = {};  ///< of the motion; a lane that is not in use has any
  std::uint32_t count = 0;
};

/// Joules, with these changes on top of the velocities at the start; summed body after body.
double kinetic_j(std::span<const BodyEnergies> bodies, const MotionChange<double>* changes);

}  // namespace poise::solver
