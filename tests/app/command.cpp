// SPDX-License-Identifier: MIT
#include "app/command.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>

#include "scene/temporary_folder.h"

extern char** environ;

namespace poise::testing {
namespace {

/// Starts the program; returns -1 if it cannot be started.
pid_t start(const std::string& out_file, const std::string& error_file, const std::vector<std::string>& arguments,
            const std::string& in_file = "/dev/null") {
  // Unless a test sets the variable, the user's cached trees and times are neither read nor written.
  ::setenv("POISE_TREE_CACHE", "off", 0);
  ::setenv("POISE_TIME_PRIORS", "off", 0);
  std::vector<std::string> words{POISE_COMMAND};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, in_file.c_str(), O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_file.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, error_file.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t child = -1;
  const int failed = ::posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  return failed == 0 ? child : -1;
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

CommandResult poise_command(const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  CommandResult result;
  result.exit_code = wait_for(start(folder.file("out"), folder.file("error"), arguments));
  result.out = contents(folder.file("out"));
  result.error = contents(folder.file("error"));
  return result;
}

CommandResult poise_command_reading(const std::string& in_file, const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  CommandResult result;
  result.exit_code = wait_for(start(folder.file("out"), folder.file("error"), arguments, in_file));
  result.out = contents(folder.file("out"));
  result.error = contents(folder.file("error"));
  return result;
}

CommandResult poise_command_into(const std::string& out_file, const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  CommandResult result;
  result.exit_code = wait_for(start(out_file, folder.file("error"), arguments));
  result.error = contents(folder.file("error"));
  return result;
}

CommandResult interrupted_command(const std::vector<std::string>& arguments, const std::string& fifo,
                                  std::string& received, int signal) {
  CommandResult result;
  if (::mkfifo(fifo.c_str(), 0600) != 0) return result;
  const int reader = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (reader < 0) return result;
  const TemporaryFolder folder;
  const pid_t child = start(folder.file("out"), folder.file("error"), arguments);
  if (child < 0) return result;
  std::array<char, 1U << 16U> block{};
  // The limit only ends a failed test; a correct program writes at once and closes the pipe when it ends.
  constexpr int kLimitMs = 300'000;
  for (pollfd waiting{reader, POLLIN, 0}; ::poll(&waiting, 1, kLimitMs) > 0;) {
    const ssize_t got = ::read(reader, block.data(), block.size());
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) break;
    if (got < 0) continue;
    if (received.empty()) ::kill(child, signal);
    received.append(block.data(), static_cast<std::size_t>(got));
  }
  ::close(reader);
  result.exit_code = wait_for(child);
  result.error = contents(folder.file("error"));
  return result;
}

CommandResult interrupted_on_terminal(const std::vector<std::string>& arguments, int signal) {
  CommandResult result;
  const int screen = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (screen < 0 || ::grantpt(screen) != 0 || ::unlockpt(screen) != 0) return result;
  std::array<char, 128> name{};
  if (::ptsname_r(screen, name.data(), name.size()) != 0) return result;
  // Kept open until the child has opened it, so that the terminal does not appear closed before.
  const int keyboard = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  const TemporaryFolder folder;
  const pid_t child = start(folder.file("out"), name.data(), arguments);
  ::close(keyboard);
  if (child < 0) return result;
  std::array<char, 1024> block{};
  // The limit only ends a failed test.
  constexpr int kLimitMs = 300'000;
  for (pollfd waiting{screen, POLLIN, 0}; ::poll(&waiting, 1, kLimitMs) > 0;) {
    const ssize_t got = ::read(screen, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    if (result.error.empty()) ::kill(child, signal);
    result.error.append(block.data(), static_cast<std::size_t>(got));
  }
  ::close(screen);
  result.exit_code = wait_for(child);
  result.out = contents(folder.file("out"));
  return result;
}

}  // namespace poise::testing
