// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

/// The machine and the build that produced a figure: every result file and every record names both.
namespace poise::io {

/// The machine of a run.
struct Machine {
  std::string system;  ///< kernel name, release and architecture
  std::string processor;
  int cores = 0;  ///< that this process may use
};
/// Queries the system; unknown parts are "unknown".
Machine this_machine();

/// Sources and tools of a program.
struct BuildFacts {
  std::string version;   ///< of the project, as `1.2.3`
  std::string commit;    ///< twelve digits, with `+changes` if files differed from it; `unknown` outside of Git
  std::string compiler;  ///< name and version
  std::string flags;     ///< build type, sanitizers, assertions
};
/// Of this build. Any thread.
BuildFacts this_build();

/// Hook of the JSON library: `json["machine"] = machine`, `json["build"] = build`.
void to_json(nlohmann::ordered_json& json, const Machine& machine);
void to_json(nlohmann::ordered_json& json, const BuildFacts& build);

}  // namespace poise::io
