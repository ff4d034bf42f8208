// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace poise::tests {

/// A file that may call functions whose results depend on the C library, and why no state depends on them.
struct OutsideTheState {
  std::string_view path;
  std::string_view reason;
};

/// The rule that a line breaks, if it is code of a room that the state of a world depends on, and calls what is not the
/// same on every machine: functions of <cmath> that are not exact, functions of Eigen that call them, and distributions
/// of <random>. `code` is free of comments and literals (code_only).
std::optional<std::string> depends_on_libm(std::string_view room, std::string_view path, std::string_view code);

}  // namespace poise::tests
