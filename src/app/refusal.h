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

}  // namespace poise::app
