// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

namespace poise::app {

/// Opens /dev/null for each of the descriptors 0 to 2 that the program was started without. Else the next file that it
/// opens has that number, and gets what is printed. To be called before any other file is opened.
void open_standard_streams() noexcept;

/// Writes to the standard error. Where that takes nothing (its disk is full, its reader has gone away) the text is
/// lost, and the program goes on: its results are worth more. Any thread.
template <class... Args>
void print_error(fmt::format_string<Args...> format, Args&&... args) {
  const std::string text = fmt::format(format, std::forward<Args>(args)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace poise::app
