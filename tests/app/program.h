// SPDX-License-Identifier: MIT
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace poise::testing {

/// The standard input and outputs of a program.
struct Streams {
  std::string out, error;
  std::string in = "/dev/null";
};

/// The built `poise`, running. Unless a test sets the variables, the user's cached trees and times are neither read nor
/// written.
class Program {
 public:
  /// Starts it, without a shell; `before` is called in the new process before the program.
  Program(Streams streams, const std::vector<std::string>& arguments, const std::function<void()>& before = {});
  /// The same with its outputs in the files `out` and `error` of a folder.
  Program(const std::string& folder, const std::vector<std::string>& arguments,
          const std::function<void()>& before = {});
  /// Ends it, if wait() did not.
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void signal(int number) const;
  /// Its exit code, 128 + signal if a signal ended it, 127 if it could not be started, -1 if there is no process.
  int wait();
  [[nodiscard]] bool ended();
  [[nodiscard]] pid_t id() const { return child_; }
  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::string error() const;

 private:
  Streams streams_;
  pid_t child_ = -1;
  int exit_code_ = -1;
  bool waited_ = false;
};

}  // namespace poise::testing
