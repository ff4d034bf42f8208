// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/report/line_chart.h"
#include "scene/made_by.h"

namespace poise::io {

/// One figure of one case; with a bound, smaller is better.
struct AccuracyRow {
  std::string case_name, figure, unit;  ///< the unit is "1" for shares and "" for counts
  double value = 0;
  std::optional<double> at_most;  ///< empty: reported only
  std::string published;          ///< published results of others; may be empty
  bool ok = true;                 ///< finite and within the bound
};

/// Drift and remaining motion of the bodies of a case; the three lists have the same length.
struct AccuracySeries {
  std::string case_name;
  std::vector<double> time_s, drift_m, kinetic_j;
};

/// The results of `poise study accuracy`.
struct AccuracyDocument {
  std::vector<AccuracyRow> rows;  ///< case after case
  std::vector<AccuracySeries> series;
  int threads = 1;
  double cpu_s = 0;  ///< CPU time of the whole study
  Machine machine;
  BuildFacts build;
};

/// Number of rows that are not ok.
std::size_t missed(const AccuracyDocument& document);

/// JSON of schema `poise.accuracy/1`, ending in a newline. A value that is not finite is null.
std::string accuracy_json(const AccuracyDocument& document);
/// A table for a terminal, and the same for docs.
std::string accuracy_table(const AccuracyDocument& document);
std::string accuracy_markdown(const AccuracyDocument& document);
/// Drift and kinetic energy over time, a line a case. Without lines where there are no series.
std::vector<app::LineChart> accuracy_charts(const AccuracyDocument& document);
/// Of each case the figure that is nearest to its bound, as a share of it.
app::LineChart bounds_chart(const AccuracyDocument& document);

}  // namespace poise::io
