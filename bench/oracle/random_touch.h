// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "oracle/exact_response.h"

namespace poise::oracle {

/// How two bodies are thrown at each other.
struct ThrowOptions {
  std::uint64_t seed = 1;
  double speed_mps = 2;      ///< of one centre against the other, > 0
  double spin_radps = 1;     ///< mean; each spin is within half of it around that, about any axis
  double restitution = 0.5;  ///< in [0, 1]
};

/// Parameters are chosen on one half of the touches and reported on the other.
enum class Half : std::uint8_t { Tune, Report };

/// One touch of the study.
struct RandomTouch {
  std::uint64_t number = 0;
  Flight a, b;           ///< from the start, where the bounding balls are apart
  double horizon_s = 0;  ///< after it the bounding balls have parted again
  FirstTouch touch;
  Answer answer;
  int missed = 0;   ///< throws before this one that missed
  int grazing = 0;  ///< and that touched at less than 1 % of the speed
  int undecided = 0;

  /// Even numbers are for tuning.
  [[nodiscard]] Half half() const { return number % 2 == 0 ? Half::Tune : Half::Report; }
};

/// Touch number `number` of a pair of shapes under a seed: orientations evenly distributed, b aimed at any point of the
/// disc across a's bounding ball, thrown again until it touches. The same on every machine whose libfcl gives the same
/// distances, whatever other numbers are made. Any thread. After 10,000 throws without one, `touch.meeting` is not
/// Touch.
RandomTouch random_touch(const OracleMesh& a, const OracleMesh& b, const ThrowOptions& options, std::uint64_t number);

/// The exact answer to the same throw after b's start has been moved by `shift_m` in a random direction that depends on
/// seed, number and `draw`. Where they then miss, nothing changes: all zero.
Answer shifted_answer(const OracleMesh& a, const OracleMesh& b, const ThrowOptions& options, const RandomTouch& touch,
                      double shift_m, std::uint64_t draw);

}  // namespace poise::oracle
