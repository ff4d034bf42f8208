// SPDX-License-Identifier: MIT
#include "studies/gnuplot.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>

#include "scene/result_file.h"
#include "studies/child_command.h"

namespace poise::app {

// gnuplot reads its script from a temporary file.
Result<std::string> drawn_by_gnuplot(const std::string& script, const parallel::Interrupt& interrupt) {
  std::error_code failure;
  std::string file = (std::filesystem::temp_directory_path(failure) / "poise-plot-XXXXXX").string();
  const int handle = failure ? -1 : ::mkstemp(file.data());
  if (handle < 0) return Error{ErrorKind::OutputFailed, fmt::format("{}: cannot be made", file)};
  ::close(handle);
  const Status written = io::write_file(file, script);
  const Result<ChildResult> child =
      written ? run_program({"gnuplot", file}, interrupt) : Result<ChildResult>(written.error());
  std::filesystem::remove(file, failure);
  if (!child)
    return Error{ErrorKind::OutputFailed, fmt::format("--picture needs gnuplot-nox: {}", child.error().message)};
  if (child.value().exit_code != 0) {
    return Error{ErrorKind::OutputFailed, fmt::format("--picture: gnuplot ended with {}", child.value().exit_code)};
  }
  return child.value().out;
}

}  // namespace poise::app
