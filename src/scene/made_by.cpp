// SPDX-License-Identifier: MIT
#include "scene/made_by.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "parallel/executor.h"

namespace poise::io {

Machine this_machine() {
  Machine machine{"unknown", "unknown", parallel::available_threads()};
  struct utsname names {};
  if (::uname(&names) == 0) machine.system = fmt::format("{} {} {}", names.sysname, names.release, names.machine);
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
      machine.processor = line.substr(colon + 2);
      break;
    }
  }
  return machine;
}

void to_json(nlohmann::ordered_json& json, const Machine& machine) {
  json = {{"system", machine.system}, {"processor", machine.processor}, {"cores", machine.cores}};
}

void to_json(nlohmann::ordered_json& json, const BuildFacts& build) {
  json = {{"version", build.version}, {"commit", build.commit}, {"compiler", build.compiler}, {"flags", build.flags}};
}

}  // namespace poise::io
