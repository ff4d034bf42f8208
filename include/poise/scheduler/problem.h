// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace poise::scheduler {

/// An invalid setting: the field, its value, and the rule that it breaks. `field` and `rule` refer to texts with static
/// storage duration.
struct Problem {
  std::string_view field;
  double value = 0;
  double least = 0;  ///< the field's range, both ends included
  double most = 0;
  std::string_view rule;  ///< a rule that is not a range, e.g. "must be unique"; empty: the range is the rule
};

/// One line of text, e.g. `closing_scale_mps = -1, must be in [1e-06, 1e+06]`.
std::string text_of(const Problem& problem);

}  // namespace poise::scheduler
