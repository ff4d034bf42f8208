// SPDX-License-Identifier: MIT
#include "app/process_memory.h"

#include <fstream>
#include <sstream>
#include <string>

namespace poise::app {

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

}  // namespace poise::app
