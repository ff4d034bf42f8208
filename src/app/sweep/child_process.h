// SPDX-License-Identifier: MIT
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "poise/result.h"

namespace poise::app {

/// This program once more, running beside itself, in a process group of its own: signals of a terminal do not reach it,
/// and all that it starts ends with it. Invariant: while it runs, its number is not given to another.
class ChildProcess {
 public:
  /// Exit code of one that could not be started.
  static constexpr int kNotStarted = 127;
  /// Starts this program, even if its file was replaced meanwhile, with these arguments. What it prints goes to the
  /// file `log`, from its beginning; it reads nothing. It is bound to `processors` where there are any. It is ended
  /// (SIGKILL) when this program ends, however that happens. Refused: what the system refuses.
  static Result<ChildProcess> start(const std::vector<std::string>& words, const std::filesystem::path& log,
                                    const std::vector<int>& processors);
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  /// Ends it and waits, if it is not over.
  ~ChildProcess();

  /// A descriptor that poll() finds readable once it is over; -1 where the system has none.
  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// Whether it is over; does not wait.
  bool over();
  /// Ends its group with SIGKILL and waits for it.
  void end();
  /// Of a program that is over: its exit code, 128 + signal if a signal ended it.
  [[nodiscard]] int exit_code() const { return exit_code_; }

 private:
  ChildProcess() = default;
  bool collect(int options);

  pid_t pid_ = -1;  ///< -1: over
  int descriptor_ = -1;
  int exit_code_ = -1;
};

/// What a program printed, and its exit code; 127 if it could not be started.
struct ProgramOutput {
  int exit_code = 127;
  std::string out, error;
};

/// Runs a program of the path to its end.
ProgramOutput run_program(const std::vector<std::string>& words);

}  // namespace poise::app
