// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "parallel/interrupt.h"
#include "poise/result.h"

namespace poise::app {

struct ChildResult {
  int exit_code = 0;  ///< 128 + signal if a signal ended it
  std::string out;    ///< what it wrote to its standard output
};

/// Runs a program, found by the shell's rules, in a child process with our standard error. Waits for it and passes
/// Ctrl-C on. Refused: the process cannot be started.
Result<ChildResult> run_program(std::vector<std::string> words, const parallel::Interrupt& interrupt);

/// Runs the `poise` beside this program with these arguments in a child process with our standard error, so that CPU
/// time and memory of the child can be measured separately. Waits for it and passes Ctrl-C on. Refused: the process
/// cannot be started.
Result<ChildResult> run_child(const std::vector<std::string>& arguments, const parallel::Interrupt& interrupt);

}  // namespace poise::app
