// SPDX-License-Identifier: MIT
#include "app/sweep/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

extern char** environ;

namespace poise::app {
namespace {

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> list;
  for (std::string& word : words) list.push_back(word.data());
  list.push_back(nullptr);
  return list;
}

/// In the new process, before the program. Only calls that a process with several threads may make after fork().
void become(char* const* words, int log, int input, const cpu_set_t* processors, pid_t parent) {
  ::setpgid(0, 0);
  // The parent may have ended before the system was told to watch it.
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || ::getppid() != parent) ::_exit(ChildProcess::kNotStarted);
  if (processors != nullptr) ::sched_setaffinity(0, sizeof(*processors), processors);
  ::dup2(input, STDIN_FILENO);
  ::dup2(log, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  // The file that this process runs, whatever is under its name now.
  ::execv("/proc/self/exe", words);
  ::_exit(ChildProcess::kNotStarted);
}

void drain(int out, int error, ProgramOutput& output) {
  std::array<pollfd, 2> ends{pollfd{out, POLLIN, 0}, pollfd{error, POLLIN, 0}};
  const std::array<std::string*, 2> texts{&output.out, &output.error};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (::poll(ends.data(), ends.size(), -1) < 0 && errno != EINTR) return;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      std::array<char, 4096> block{};
      const ssize_t got = ::read(ends[i].fd, block.data(), block.size());
      if (got > 0) texts[i]->append(block.data(), static_cast<std::size_t>(got));
      if (got == 0 || (got < 0 && errno != EINTR)) ends[i].fd = -1;
    }
  }
}

}  // namespace

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& words, const std::filesystem::path& log,
                                         const std::vector<int>& processors) {
  const auto refused = [](const std::string& what) {
    return Error{ErrorKind::OutputFailed, what + ": " + std::strerror(errno)};
  };
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (out < 0) return refused(log.string() + ": cannot be written");
  const int input = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int processor : processors) {
    if (processor >= 0 && processor < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(processor), &set);
  }
  std::vector<std::string> copy = words;
  copy.insert(copy.begin(), "poise");
  const std::vector<char*> argv = pointers(copy);
  ChildProcess child;
  const pid_t parent = ::getpid();
  child.pid_ = ::fork();
  if (child.pid_ == 0) become(argv.data(), out, input, processors.empty() ? nullptr : &set, parent);
  const int failure = errno;
  ::close(out);
  if (input >= 0) ::close(input);
  errno = failure;
  if (child.pid_ < 0) return refused("poise: cannot be started");
  // Here too, so that the group exists whichever of the two comes first.
  ::setpgid(child.pid_, child.pid_);
  child.descriptor_ = static_cast<int>(::syscall(SYS_pidfd_open, child.pid_, 0));
  return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      exit_code_(other.exit_code_) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(exit_code_, other.exit_code_);
  return *this;
}

ChildProcess::~ChildProcess() {
  end();
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool ChildProcess::collect(int options) {
  if (pid_ < 0) return true;
  int status = 0;
  pid_t got = -1;
  do {
    got = ::waitpid(pid_, &status, options);
  } while (got < 0 && errno == EINTR);
  if (got == 0) return false;
  exit_code_ = got < 0 ? -1 : WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  pid_ = -1;
  return true;
}

bool ChildProcess::over() { return collect(WNOHANG); }

void ChildProcess::end() {
  if (pid_ < 0) return;
  ::kill(-pid_, SIGKILL);
  collect(0);
}

ProgramOutput run_program(const std::vector<std::string>& words) {
  ProgramOutput output;
  std::array<int, 2> out{}, error{};
  if (::pipe2(out.data(), O_CLOEXEC) != 0) return output;
  if (::pipe2(error.data(), O_CLOEXEC) != 0) {
    ::close(out[0]);
    ::close(out[1]);
    return output;
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, error[1], STDERR_FILENO);
  std::vector<std::string> copy = words;
  const std::vector<char*> argv = pointers(copy);
  pid_t child = -1;
  const int failed = ::posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(out[1]);
  ::close(error[1]);
  if (failed != 0) {
    output.error = std::strerror(failed);
  } else {
    drain(out[0], error[0], output);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    output.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  ::close(out[0]);
  ::close(error[0]);
  return output;
}

}  // namespace poise::app
