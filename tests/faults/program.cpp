// SPDX-License-Identifier: MIT
#include "faults/program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>

#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

void redirect(const std::string& file, int descriptor) {
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (opened >= 0) ::dup2(opened, descriptor);
}

}  // namespace

Program::Program(const std::string& folder, const std::vector<std::string>& arguments,
                 const std::function<void()>& before)
    : folder_(folder) {
  ::setenv("POISE_TIME_PRIORS", "off", 0);
  std::vector<std::string> words{POISE_COMMAND};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  child_ = ::fork();
  if (child_ != 0) return;
  redirect(folder + "/out", STDOUT_FILENO);
  redirect(folder + "/error", STDERR_FILENO);
  if (before) before();
  ::execv(argv[0], argv.data());
  ::_exit(127);
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

std::string Program::out() const { return contents(folder_ + "/out"); }

std::string Program::error() const { return contents(folder_ + "/error"); }

}  // namespace poise::testing
