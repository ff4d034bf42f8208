// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "scene/field_reader.h"
#include "sweep/run_settings.h"

namespace poise::sweep {

/// The most trials of one sweep. Chosen: each has files of its own in one folder.
inline constexpr std::uint64_t kMostTrials = 100'000;

/// The most settings and axes of a specification together. Chosen: more than twice as many as there are, since each
/// trial has all of them; weights of cues may have any name.
inline constexpr std::size_t kMostSettings = 64;

/// A setting that takes several values; trials are made for each of them.
struct Axis {
  std::string name;
  std::vector<Setting> values;  ///< at least one, no two alike
};

/// Which value of an axis is the largest at which all requirements hold, for each value of another.
struct Frontier {
  std::string largest;  ///< name of an axis of numbers
  std::string against;  ///< name of another one
};

/// The checked content of a specification, `poise.sweep/1` (docs/sweep.md).
struct SweepSpec {
  std::string name;                       ///< that of the file unless it says another
  std::string source;                     ///< the file, for messages
  std::string base;                       ///< folder that its relative files are relative to
  std::vector<std::string> scenes;        ///< names of shipped scenes, or files, as written; at least one
  std::vector<Setting> settings;          ///< of all trials
  std::vector<Axis> axes;                 ///< in the order of the file; `seeds` are the last one, named `seed`
  std::uint64_t repeats = 1;              ///< trials with the same settings
  std::vector<std::string> requirements;  ///< as `poise run --require` has them
  std::optional<Frontier> frontier;
  std::vector<std::string> figures;    ///< what the curves of the report show
  std::optional<std::uint64_t> cores;  ///< that a trial needs; empty: as many as its threads, at least one
  double time_limit_s = 3600;          ///< after which a trial is ended
};

/// Reads and checks a specification. Refused with file, field, value and rule; `errors` receives all refusals, one line
/// each. Values are checked by their kinds alone (read_setting).
Result<SweepSpec> read_spec(const std::filesystem::path& file, std::vector<std::string>& errors);
/// The same from text; messages begin with `name`.
Result<SweepSpec> parse_spec(std::string_view text, const std::string& name, const std::filesystem::path& base,
                             std::vector<std::string>& errors);

/// Names of the figures of a run that requirements and curves may use.
std::vector<std::string> figure_names();

}  // namespace poise::sweep
