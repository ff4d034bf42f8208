// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/report/line_chart.h"
#include "scene/made_by.h"
#include "verify/pair_probe.h"

namespace poise::io {

/// A pair of shapes of the study, and the oracle's figures for it.
struct LevelsPair {
  std::string shape_a, shape_b;
  std::string group;  ///< round, flat or other
  std::size_t touches = 0;
  std::size_t missed = 0, grazing = 0, undecided = 0;     ///< throws without a contact
  std::size_t vertex_face = 0, edge_edge = 0, other = 0;  ///< contacts by their features
  double dv_mps = 0;                                      ///< mean |dv| of the exact result; errors are shares of it
  double dw_mps = 0;                                      ///< mean rho |dw| of the two bodies
  double uncertainty = 0;  ///< mean change of the exact dv when b is moved by 1/1000 of the size, as a share of dv_mps
  double uncertainty_three = 0;  ///< the same for 3/1000
};

/// Mean, median and 90th percentile of an error as a share of the mean exact result.
struct ErrorSpread {
  double mean = 0, median = 0, p90 = 0;
};

/// Accuracy of one contact model at one level over the contacts of a pair of shapes.
struct LevelsRow {
  std::size_t pair = 0;  ///< index in LevelsDocument::pairs
  std::string model;
  simulation::ProbeLevel level;
  ErrorSpread dv, dw;
  double toc_ms_mean = 0;        ///< mean |time of the impulse - exact time|, at most kLongestWaitMs for each contact
  double toc_early_ms_mean = 0;  ///< mean time by which the impulse was early; 0 for late ones
  double late_share = 0;         ///< impulse more than 1/60 s after the contact, or none
  double unseen_share = 0;       ///< contacts that the level did not find
  simulation::PairCost cost;
};

/// A contact without an impulse after this time counts as having none.
inline constexpr double kLongestWaitMs = 100;

/// The results of `poise study levels`.
struct LevelsDocument {
  std::string half;  ///< tune, report or all
  std::uint64_t seed = 0;
  std::size_t touches = 0;  ///< requested number for each pair of shapes
  int depth = 0;            ///< of the trees
  int fineness = 1;         ///< of the round parts of named shapes
  int threads = 0;
  double speed_mps = 0, spin_radps = 0, restitution = 0, dt_s = 0;
  std::vector<LevelsPair> pairs;
  std::vector<LevelsRow> rows;  ///< in the order of pairs, models, then levels ascending
  Machine machine;
  BuildFacts build;
};

/// "0" to "6", or "polygons".
std::string level_name(simulation::ProbeLevel level);

/// The means over the pairs of a group, a model and a level.
struct LevelsSummary {
  std::string group, model;
  simulation::ProbeLevel level;
  std::size_t pairs = 0;
  ErrorSpread dv, dw;
  double toc_ms_mean = 0, late_share = 0, unseen_share = 0;
  simulation::PairCost cost;
  std::optional<double> target;  ///< mean error of dv to be reached
};
std::vector<LevelsSummary> summaries(const LevelsDocument& document);

/// A level with a larger error than the previous one, by more than 2 % and more than the oracle's own uncertainty.
struct LevelsSetback {
  std::size_t row = 0;  ///< index in LevelsDocument::rows
  double before = 0;    ///< mean error of dv of the previous level
};
std::vector<LevelsSetback> setbacks(const LevelsDocument& document);

/// JSON of schema `poise.levels/2`, ending in a newline.
std::string levels_json(const LevelsDocument& document);
/// One line a row, with a header.
std::string levels_csv(const LevelsDocument& document);
/// Tables for a terminal, and the same for docs.
std::string levels_table(const LevelsDocument& document);
std::string levels_markdown(const LevelsDocument& document);

/// Error against level: a line a model, a chart a group.
std::vector<app::LineChart> levels_charts(const LevelsDocument& document);

}  // namespace poise::io
