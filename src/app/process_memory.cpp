// SPDX-License-Identifier: MIT
#include "app/process_memory.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "app/option_values.h"

namespace poise::app {
namespace {

constexpr std::uint64_t kMostMegabytes = 1U << 30U;  // a pebibyte

}  // namespace

void forget_peak_memory() { std::ofstream("/proc/self/clear_refs") << 5; }

std::uint64_t peak_memory_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmHWM:", 0) != 0) continue;
    std::uint64_t kilobytes = 0;
    std::istringstream(line.substr(6)) >> kilobytes;
    return 1024 * kilobytes;
  }
  return 0;
}

std::uint64_t machine_memory_bytes() {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page_bytes = ::sysconf(_SC_PAGESIZE);
  std::uint64_t bytes =
      pages > 0 && page_bytes > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes) : 0;
  // `max` there is no number: no limit.
  std::uint64_t of_group = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> of_group && of_group > 0)
    bytes = bytes == 0 ? of_group : std::min(bytes, of_group);
  return bytes;
}

void add_max_memory(CLI::App& command, std::optional<std::uint64_t>& megabytes) {
  add_whole(command, "--max-memory", megabytes, 1, kMostMegabytes,
            "Refuse bodies that would take more memory than so many MiB, and leave out contacts of crowds that would "
            "(default: what the machine has)");
}

std::optional<std::uint64_t> max_memory_bytes(const std::optional<std::uint64_t>& megabytes) {
  if (megabytes) return *megabytes << 20U;
  const std::uint64_t bytes = machine_memory_bytes();
  return bytes > 0 ? std::optional(bytes) : std::nullopt;
}

}  // namespace poise::app
