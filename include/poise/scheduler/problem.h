// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace poise::scheduler {

/// What is wrong with a setting: which field, its value, and the rule that it breaks. `field` and `rule` are views of
/// texts that live as long as the program.
struct Problem {
  std::string_view field;
  double value = 0;
  double least = 0;  ///< the field's range, both ends allowed
  double most = 0;
  std::string_view rule;  ///< a rule that no range can say, e.g. "must be unique"; empty: the range
};

/// `closing_scale_mps = -1, must be in [1e-06, 1e+06]`.
std::string text_of(const Problem& problem);

}  // namespace poise::scheduler
