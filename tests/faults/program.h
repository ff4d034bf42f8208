// SPDX-License-Identifier: MIT
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace poise::testing {

/// The built `poise`, running. Its outputs go to the files `out` and `error` of a folder.
class Program {
 public:
  /// Starts it in `folder`; `before` is called in the new process before the program.
  Program(const std::string& folder, const std::vector<std::string>& arguments,
          const std::function<void()>& before = {});
  /// Ends it, if wait() did not.
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void signal(int number) const;
  /// Its exit code, 128 + signal if a signal ended it, -1 if it could not be started.
  int wait();
  [[nodiscard]] bool ended();
  [[nodiscard]] pid_t id() const { return child_; }
  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::string error() const;

 private:
  std::string folder_;
  pid_t child_ = -1;
  int exit_code_ = -1;
  bool waited_ = false;
};

}  // namespace poise::testing
