// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "poise/result.h"

namespace poise::app {

/// Tells on stderr why a command ends, as `poise COMMAND: message`, and returns `code`.
int refuse(std::string_view command, int code, const std::string& message);
/// The same with the exit code of the error.
int refuse(std::string_view command, const Error& error);

/// The refusal of work that a signal stopped: `stopped by Ctrl-C; LEFT`.
Error stopped_error(std::string_view left = "nothing was written");

/// What is left of a scene that was stopped before its first frame.
inline constexpr std::string_view kStoppedLoading = "nothing was written; finished trees are in the cache, if it is on";

/// Adds what failed to what failed before: the first kind, and all messages, separated by `; `.
void add_failure(const Status& status, Status& all);

}  // namespace poise::app
