// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/made_by.h"
#include "verify/pair_probe.h"

namespace poise::io {

/// A pair of shapes of the study, and how the oracle measured it.
struct LevelsPair {
  std::string shape_a, shape_b;
  std::string group;  ///< round, flat or other
  std::size_t touches = 0;
  std::size_t missed = 0, grazing = 0, undecided = 0;     ///< throws that gave no touch
  std::size_t vertex_face = 0, edge_edge = 0, other = 0;  ///< touches by their features
  double dv_mps = 0;                                      ///< mean |dv| of the exact answer, which errors are shares of
  double dw_mps = 0;                                      ///< mean rho |dw| of the two bodies
  double uncertainty = 0;  ///< mean change of the exact dv when b is moved by 1/1000 of the size, as a share of dv_mps
  double uncertainty_three = 0;  ///< the same for 3/1000
};

/// Mean, median and 90th percentile of an error as a share of the exact answer's mean.
struct ErrorSpread {
  double mean = 0, median = 0, p90 = 0;
};

/// How one contact model did at one level over the touches of a pair of shapes.
struct LevelsRow {
  std::size_t pair = 0;  ///< place in LevelsDocument::pairs
  std::string model;
  simulation::ProbeLevel level;
  ErrorSpread dv, dw;
  double toc_ms_mean = 0;        ///< mean |time of the answer - exact time|, at most kLongestWaitMs for each touch
  double toc_early_ms_mean = 0;  ///< mean of how much too early, 0 for touches that were late
  double late_share = 0;         ///< answered more than 1/60 s after the touch, or not at all
  double unseen_share = 0;       ///< touches at which the level found nothing
  simulation::PairCost cost;
};

/// A touch that is not answered so long after it never is.
inline constexpr double kLongestWaitMs = 100;

/// What `poise study levels` found.
struct LevelsDocument {
  std::string half;  ///< tune, report or all
  std::uint64_t seed = 0;
  std::size_t touches = 0;  ///< asked for, a pair of shapes
  int depth = 0;            ///< of the trees
  int fineness = 1;         ///< of the round parts of named shapes
  int threads = 0;
  double speed_mps = 0, spin_radps = 0, restitution = 0, dt_s = 0;
  std::vector<LevelsPair> pairs;
  std::vector<LevelsRow> rows;  ///< pair after pair, model after model, levels ascending
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
  std::optional<double> target;  ///< mean error of dv that is to be reached
};
std::vector<LevelsSummary> summaries(const LevelsDocument& document);

/// A level that is worse than the one before by more than 2 % and the oracle's own uncertainty.
struct LevelsSetback {
  std::size_t row = 0;  ///< place in LevelsDocument::rows
  double before = 0;    ///< mean error of dv of the level before
};
std::vector<LevelsSetback> setbacks(const LevelsDocument& document);

/// `poise.levels/2`, ending in a newline.
std::string levels_json(const LevelsDocument& document);
/// One line a row, with a header.
std::string levels_csv(const LevelsDocument& document);
/// Tables for a terminal, and the same for docs.
std::string levels_table(const LevelsDocument& document);
std::string levels_markdown(const LevelsDocument& document);

/// A script for gnuplot 5 that writes a PNG to its standard output: error against level, a line a model, a panel a
/// group.
std::string levels_plot(const LevelsDocument& document);

}  // namespace poise::io
