// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "parallel/interrupt.h"
#include "poise/result.h"

namespace poise::app {

struct ChildResult {
  int exit_code = 0;  ///< 128 + signal where a signal ended it
  std::string out;    ///< what it wrote to its standard output
};

/// Runs a program, found as a shell finds it, in a process of its own; its messages go where ours go. Waits for it;
/// Ctrl-C is passed on. Refused: the system starts no such process.
Result<ChildResult> run_program(std::vector<std::string> words, const parallel::Interrupt& interrupt);

/// Runs `poise`, beside this program, with these arguments in a process of its own, so that what it measures of itself
/// is its own; its messages go where ours go. Waits for it; Ctrl-C is passed on. Refused: the system starts no process.
Result<ChildResult> run_child(const std::vector<std::string>& arguments, const parallel::Interrupt& interrupt);

}  // namespace poise::app
