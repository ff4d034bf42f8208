// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace poise::scheduler {

/// How the next refinement is chosen.
enum class PolicyKind : std::uint8_t {
  Perceptual,  ///< most noticeable gain per second first
  Fifo,        ///< first come, first served; a refined pair goes to the back
  Random,      ///< an order drawn anew each frame from the seed
};

/// A policy is data: a rule and its weights. Each cue enters the score as a factor; weight 0 switches the cue off.
struct Policy {
  PolicyKind kind = PolicyKind::Perceptual;
  double frustum = 1;        ///< exponent of visibility (outside the frustum: kOutsideFrustum)
  double size = 1;           ///< exponent of the visible angle of the error, against a fixed angle
  double eccentricity = 1;   ///< exponent of 1 / (1 + E / E2)
  double closing = 1;        ///< exponent of 1 + closing speed / (1 m/s)
  double waiting = 1;        ///< exponent of 1 + frames waited since last served
  double importance = 1;     ///< exponent of the importance that the scene gives
};

}  // namespace poise::scheduler
