// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"

namespace poise::app {

/// Result of a run under valgrind's callgrind.
struct Counted {
  std::uint64_t instructions = 0;      ///< executed while counting was on
  std::vector<std::string> functions;  ///< functions in which instructions were executed, in no order
};

/// Reads a profile (callgrind's format, version 1): the total and the names of functions. Refused: text without either.
Result<Counted> read_callgrind(std::string_view text);

/// The functions whose names contain any of the parts.
std::vector<std::string> with_any(const std::vector<std::string>& functions, const std::vector<std::string>& parts);

}  // namespace poise::app
