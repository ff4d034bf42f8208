// SPDX-License-Identifier: MIT
#include "app/program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <utility>

#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

constexpr int kNotStarted = 127;

void redirect(const std::string& file, int flags, int descriptor) {
  const int opened = ::open(file.c_str(), flags, 0600);
  if (opened < 0 || ::dup2(opened, descriptor) < 0) ::_exit(kNotStarted);
  ::close(opened);
}

}  // namespace

Program::Program(const std::string& folder, const std::vector<std::string>& arguments,
                 const std::function<void()>& before)
    : Program(Streams{folder + "/out", folder + "/error"}, arguments, before) {}

Program::Program(Streams streams, const std::vector<std::string>& arguments, const std::function<void()>& before)
    : streams_(std::move(streams)) {
  ::setenv("POISE_TREE_CACHE", "off", 0);
  ::setenv("POISE_TIME_PRIORS", "off", 0);
  std::vector<std::string> words{POISE_COMMAND};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  child_ = ::fork();
  if (child_ != 0) return;
  redirect(streams_.in, O_RDONLY, STDIN_FILENO);
  redirect(streams_.out, O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
  redirect(streams_.error, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
  // A shell that starts the tests in the background ignores SIGINT for them, and what they start would too.
  ::signal(SIGINT, SIG_DFL);
  if (before) before();
  ::execv(argv[0], argv.data());
  ::_exit(kNotStarted);
}

Program::~Program() {
  if (waited_) return;
  signal(SIGKILL);
  wait();
}

void Program::signal(int number) const {
  if (child_ > 0 && !waited_) ::kill(child_, number);
}

int Program::wait() {
  if (waited_ || child_ <= 0) return exit_code_;
  int status = 0;
  while (::waitpid(child_, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  waited_ = true;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return exit_code_;
}

bool Program::ended() {
  if (waited_ || child_ <= 0) return true;
  siginfo_t info{};
  return ::waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == child_;
}

std::string Program::out() const { return contents(streams_.out); }

std::string Program::error() const { return contents(streams_.error); }

}  // namespace poise::testing
