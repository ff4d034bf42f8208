// SPDX-License-Identifier: MIT
#pragma once

#include <csignal>
#include <string>
#include <vector>

namespace poise::testing {

struct CommandResult {
  int exit_code = -1;  ///< 128 + signal if a signal ended it
  std::string out;
  std::string error;
};

/// Runs the built `poise` with these arguments, without a shell, and waits for it.
CommandResult poise_command(const std::vector<std::string>& arguments);

/// The same with the standard input from `in_file`.
CommandResult poise_command_reading(const std::string& in_file, const std::vector<std::string>& arguments);

/// The same, with a pipe at `fifo` that the program writes to. The program gets the signal at its first bytes.
/// `received` gets all bytes of the pipe.
CommandResult interrupted_command(const std::vector<std::string>& arguments, const std::string& fifo,
                                  std::string& received, int signal = SIGINT);

/// The same with a terminal as its standard error. The program gets the signal at its first output there. Returns that
/// output as the error text.
CommandResult interrupted_on_terminal(const std::vector<std::string>& arguments, int signal = SIGINT);

/// The same with the standard output going to `out_file`.
CommandResult poise_command_into(const std::string& out_file, const std::vector<std::string>& arguments);

}  // namespace poise::testing
