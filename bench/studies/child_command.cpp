// SPDX-License-Identifier: MIT
#include "studies/child_command.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>

#include "app/process/program_beside.h"

extern char** environ;

namespace poise::app {
namespace {

Error failed(const char* what, int reason) { return bad_input(fmt::format("{}: {}", what, std::strerror(reason))); }

/// Reads until the writer closes the pipe. Checks five times a second whether Ctrl-C must be passed on.
std::string read_all(int pipe, pid_t child, const parallel::Interrupt& interrupt) {
  std::string text;
  std::array<char, 1U << 14U> block{};
  bool told = false;
  for (;;) {
    pollfd waiting{pipe, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, 200);
    if (interrupt.asked() && !told) {
      ::kill(child, SIGINT);
      told = true;
    }
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    if (ready < 0) return text;
    const ssize_t got = ::read(pipe, block.data(), block.size());
    if (got == 0 || (got < 0 && errno != EINTR)) return text;
    if (got > 0) text.append(block.data(), static_cast<std::size_t>(got));
  }
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Result<ChildResult> run_program(std::vector<std::string> words, const parallel::Interrupt& interrupt) {
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) return failed("no pipe", errno);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  // In a process group of its own, so that the terminal's Ctrl-C reaches only this process, which passes it on once.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t child = -1;
  const int spawned = ::posix_spawnp(&child, words[0].c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  ChildResult result;
  if (spawned == 0) {
    result.out = read_all(ends[0], child, interrupt);
    result.exit_code = wait_for(child);
  }
  ::close(ends[0]);
  return spawned == 0 ? Result<ChildResult>(std::move(result)) : failed(words[0].c_str(), spawned);
}

Result<ChildResult> run_child(const std::vector<std::string>& arguments, const parallel::Interrupt& interrupt) {
  const Result<std::filesystem::path> program = program_beside("poise");
  if (!program) return program.error();
  std::vector<std::string> words{program.value().string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return run_program(std::move(words), interrupt);
}

}  // namespace poise::app
