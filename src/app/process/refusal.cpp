// SPDX-License-Identifier: MIT
#include "app/process/refusal.h"

#include <fmt/format.h>

#include <cstdio>

#include "app/process/exit_codes.h"
#include "app/process/standard_streams.h"

namespace poise::app {

int refuse(std::string_view command, int code, const std::string& message) {
  print_error("poise {}: {}\n", command, message);
  return code;
}

int refuse(std::string_view command, const Error& error) { return refuse(command, exit_code_of(error), error.message); }

Error stopped_error(std::string_view left) {
  return {ErrorKind::Cancelled, fmt::format("stopped by {}; {}", parallel::stop_name(), left)};
}

void add_failure(const Status& status, Status& all) {
  if (status) return;
  all = all ? status : Status(Error{all.error().kind, all.error().message + "; " + status.error().message});
}

}  // namespace poise::app
