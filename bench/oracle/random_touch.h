// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "oracle/exact_response.h"

namespace poise::oracle {

/// How two bodies are thrown at each other.
struct ThrowOptions {
  std::uint64_t seed = 1;
  double speed_mps = 2;      ///< of one centre relative to the other, > 0
  double spin_radps = 1;     ///< mean; each spin is within half of it around the mean, about any axis
  double restitution = 0.5;  ///< in [0, 1]
};

/// Parameters are chosen on one half of the contacts; results are reported on the other.
enum class Half : std::uint8_t { Tune, Report };

/// One contact of the study.
struct RandomTouch {
  std::uint64_t number = 0;
  Flight a, b;           ///< from the start, where the bounding balls are separated
  double horizon_s = 0;  ///< after this time the bounding balls are separated again
  FirstTouch touch;
  Answer answer;
  int missed = 0;   ///< earlier throws that missed
  int grazing = 0;  ///< earlier throws that touched at less than 1 % of the speed
  int undecided = 0;

  /// Even numbers are for tuning, odd ones for reporting.
  [[nodiscard]] Half half() const { return number % 2 == 0 ? Half::Tune : Half::Report; }
};

/// Contact number `number` of a pair of shapes for a seed. Orientations are uniformly distributed; b aims at a random
/// point of the disc across a's bounding ball; throws are repeated until one touches. The result is the same on every
/// machine whose libfcl gives the same distances, whichever other numbers are computed. Any thread. After 10,000 throws
/// without contact, `touch.outcome` is not Touch.
RandomTouch random_touch(const OracleMesh& a, const OracleMesh& b, const ThrowOptions& options, std::uint64_t number);

/// The exact result of the same throw after b's start was moved by `shift_m` in a random direction, which depends on
/// seed, number and `draw`. All zero if the bodies then miss.
Answer shifted_answer(const OracleMesh& a, const OracleMesh& b, const ThrowOptions& options, const RandomTouch& touch,
                      double shift_m, std::uint64_t draw);

}  // namespace poise::oracle
