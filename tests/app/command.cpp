// SPDX-License-Identifier: MIT
#include "app/command.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "app/program.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
CommandResult poise_command(const std::vector<std::string>& arguments) {
  return poise_command_reading("/dev/null", arguments);
}

CommandResult poise_command_reading(const std::string& in_file, const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  Program program(Streams{folder.file("out"), folder.file("error"), in_file}, arguments);
  const int exit_code = program.wait();
  return {exit_code, program.out(), program.error()};
}

CommandResult poise_command_into(const std::string& out_file, const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  Program program(Streams{out_file, folder.file("error")}, arguments);
  const int exit_code = program.wait();
  return {exit_code, "", program.error()};
}

CommandResult interrupted_command(const std::vector<std::string>& arguments, const std::string& fifo,
                                  std::string& received, int signal) {
  CommandResult result;
  if (::mkfifo(fifo.c_str(), 0600) != 0) return result;
  const int reader = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (reader < 0) return result;
  const TemporaryFolder folder;
  Program program(folder.path(), arguments);
  std::array<char, 1U << 16U> block{};
  // The limit only ends a failed test; a correct program writes at once and closes the pipe when it ends.
  constexpr int kLimitMs = 300'000;
  for (pollfd waiting{reader, POLLIN, 0}; ::poll(&waiting, 1, kLimitMs) > 0;) {
    const ssize_t got = ::read(reader, block.data(), block.size());
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) break;
    if (got < 0) continue;
    if (received.empty()) program.signal(signal);
    received.append(block.data(), static_cast<std::size_t>(got));
  }
  ::close(reader);
  result.exit_code = program.wait();
  result.error = program.error();
  return result;
}

CommandResult interrupted_on_terminal(const std::vector<std::string>& arguments, int signal) {
  CommandResult result;
  const int screen = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (screen < 0 || ::grantpt(screen) != 0 || ::unlockpt(screen) != 0) return result;
  std::array<char, 128> name{};
  if (::ptsname_r(screen, name.data(), name.size()) != 0) return result;
  // The child has it too until it has opened its own, so that the terminal does not appear closed before.
  const int keyboard = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  const TemporaryFolder folder;
  Program program(Streams{folder.file("out"), name.data()}, arguments);
  ::close(keyboard);
  std::array<char, 1024> block{};
  // The limit only ends a failed test.
  constexpr int kLimitMs = 300'000;
  for (pollfd waiting{screen, POLLIN, 0}; ::poll(&waiting, 1, kLimitMs) > 0;) {
    const ssize_t got = ::read(screen, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    if (result.error.empty()) program.signal(signal);
    result.error.append(block.data(), static_cast<std::size_t>(got));
  }
  ::close(screen);
  result.exit_code = program.wait();
  result.out = program.out();
  return result;
}

}  // namespace poise::testing
