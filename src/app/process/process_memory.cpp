// SPDX-License-Identifier: MIT
#include "app/process/process_memory.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "app/options/option_values.h"

namespace poise::app {
namespace {

constexpr std::uint64_t kMostMegabytes = 1U << 30U;  // a pebibyte

/// The files with the memory limits of the control groups that this process is in, of both versions (cgroups(7)): a
/// group also keeps the limits of those above it. Inside a container the path may be that outside, and the limit is at
/// the root.
std::vector<std::filesystem::path> limits_of_groups() {
  std::vector<std::filesystem::path> files;
  const auto add = [&](const std::filesystem::path& root, std::filesystem::path group, const char* file) {
    for (; group.has_relative_path(); group = group.parent_path()) files.push_back(root / group.relative_path() / file);
    files.push_back(root / file);
  };
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::filesystem::path group = line.substr(second + 1);
    if (controllers == ",,") add("/sys/fs/cgroup", group, "memory.max");
    if (controllers.find(",memory,") != std::string::npos) add("/sys/fs/cgroup/memory", group, "memory.limit_in_bytes");
  }
  return files;
}

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
  for (const std::filesystem::path& file : limits_of_groups()) {
    // `max` in it is no number: no limit.
    std::uint64_t of_group = 0;
    if (std::ifstream(file) >> of_group && of_group > 0) bytes = bytes == 0 ? of_group : std::min(bytes, of_group);
  }
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
