// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "scene/run/run_report.h"
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

/// Whether a row keeps its promise. Complies: of its misses, those that the machine did not cause may be as rare as
/// alpha (lower end of their exact 95 % interval), and refinement used nine tenths of its time. Out of reach: more than
/// half of its releases are infeasible.
enum class Compliance : std::uint8_t { Complies, Fails, OutOfReach };
Compliance compliance_of(const simulation::MissFigures& misses, double alpha, std::optional<double> refinement_used);

/// Measures whether deadlines are met as often as requested, from half to eight times the population that full
/// refinement can serve. Exit code kExitRequirementFailed if a row within reach does not comply.
int study_compliance(const StudyComplianceOptions& options);

}  // namespace poise::app
