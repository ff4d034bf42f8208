// SPDX-License-Identifier: MIT
#include "scene/result_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <system_error>

namespace poise::io {

Status write_stdout(std::string_view text) {
  std::fflush(stdout);
  const int reason = geometry::write_all(STDOUT_FILENO, text);
  if (reason == 0) return Done{};
  return Error{ErrorKind::OutputFailed,
               fmt::format("standard output: cannot be written: {}", std::generic_category().message(reason))};
}

}  // namespace poise::io
