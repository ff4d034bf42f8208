// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/made_by.h"

namespace poise::io {

/// One figure of one case; less is better where there is a bound.
struct AccuracyRow {
  std::string case_name, figure, unit;  ///< the unit is "1" for shares and "" for counts
  double value = 0;
  std::optional<double> at_most;  ///< none: reported, not measured
  std::string published;          ///< what others reached; may be empty
  bool ok = true;                 ///< finite and within the bound
};

/// How far the bodies of a case have moved and how much they still do; the three lists are equally long.
struct AccuracySeries {
  std::string case_name;
  std::vector<double> time_s, drift_m, kinetic_j;
};

/// What `poise study accuracy` found.
struct AccuracyDocument {
  std::vector<AccuracyRow> rows;  ///< case after case
  std::vector<AccuracySeries> series;
  int threads = 1;
  double cpu_s = 0;  ///< CPU time of the whole study
  Machine machine;
  BuildFacts build;
};

/// Rows that are not ok.
std::size_t missed(const AccuracyDocument& document);

/// `poise.accuracy/1`, ending in a newline. A value that is not finite is null.
std::string accuracy_json(const AccuracyDocument& document);
/// A table for a terminal, and the same for docs.
std::string accuracy_table(const AccuracyDocument& document);
std::string accuracy_markdown(const AccuracyDocument& document);
/// A script for gnuplot 5 that writes a PNG to its standard output: drift and kinetic energy over time, a line a case.
/// Empty without series.
std::string accuracy_plot(const AccuracyDocument& document);

}  // namespace poise::io
