// SPDX-License-Identifier: MIT
#pragma once

#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study compliance`.
struct StudyComplianceOptions {
  StudyTimesOptions common;
  std::vector<double> alphas;           ///< empty: 0.01 and 0.001
  std::vector<double> populations;      ///< empty: 0.5, 1, 2, 4, 8 times what full refinement serves
  std::optional<std::uint64_t> bodies;  ///< population that full refinement can serve, if known
  bool competing_load = false;
};
void add_study_compliance_options(CLI::App& command, StudyComplianceOptions& options);

/// Measures whether deadlines are met as often as requested, from half to eight times the population that full
/// refinement can serve. Exit code kExitRequirementFailed if a row does not comply.
int study_compliance(const StudyComplianceOptions& options);

}  // namespace poise::app
