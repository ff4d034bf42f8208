// SPDX-License-Identifier: MIT
#pragma once

#include "studies/overload_drive.h"
#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study overload`.
struct StudyOverloadOptions {
  StudyTimesOptions common;
  std::string drive = "both";  ///< `deadline`, `population` or `both`
  std::string clock;           ///< `wall` (or empty) or `work`
  std::optional<std::uint64_t> bodies, settle, hold, reference_every;
  std::optional<double> most, shake_mps;
};
void add_study_overload_options(CLI::App& command, StudyOverloadOptions& options);

/// Measures whether a scene gets out of overload again: drives its demand from half of the budget to a multiple of it
/// and back.
int study_overload(const StudyOverloadOptions& options);

/// One drive of the study, for its table.
struct OverloadPart {
  std::string drive;  ///< `deadline` or `population`
  bool wall_clock = true;
  OverloadUnit unit;
  std::vector<simulation::OverloadRow> rows;
  std::vector<simulation::OverloadLoop> loops;
  simulation::Recovery recovery;
};
OverloadPart overload_part(const OverloadSettings& settings, const OverloadDrive& drive);
/// Appends the rows of a drive to the table and its loops to the summary; sets the columns.
void add_overload_part(const OverloadPart& part, io::StudyTable& table);

}  // namespace poise::app
