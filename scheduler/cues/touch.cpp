// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kTouch{
    "touch", &Policy::touch,
    "1, separation s as far as it is known over its expected error, negative where the surfaces overlap",
    "what does not touch has no response that could be wrong; the form is chosen",
    // The root of the chance that the surfaces touch, if the error has Student's distribution (2 degrees), since an
    // error of x with a chance of p adds p x^2 to a mean of squares; relative to that of a pair of which nothing is
    // known.
    [](const Policy&, const PairCues& cues) {
      const double known = std::isnan(cues.separation) ? 0.0 : static_cast<double>(cues.separation);
      const double z = std::clamp(known, -kMostFactor, kMostFactor);
      const double root = std::sqrt(1.0 + z * z);
      // 1 - z / root, without the difference of what is nearly equal.
      return std::sqrt(z > 0 ? 1.0 / (root * (root + z)) : 1.0 - z / root);
    }};

}  // namespace poise::scheduler::cues
