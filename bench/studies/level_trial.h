// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "oracle/random_touch.h"
#include "parallel/executor.h"
#include "poise/assets/tree_cache.h"
#include "studies/levels_document.h"
#include "world/contact_model_names.h"

namespace poise::app {

/// A shape for the oracle and for the engine.
struct TrialShape {
  std::string name;
  oracle::OracleMesh body;
  ShapePtr shape;
  bool round = false;  ///< jack, torus and bowl
  bool procedural = false;
};

/// Makes a shape by its name and fineness (poise shape), or from a file, which is scaled to a size of 1 m, with a tree
/// from the cache. Refused: a file that cannot be read, a mesh that is not closed, a build that was stopped.
Result<TrialShape> make_trial_shape(const std::string& name, int fineness, const TreeBuildOptions& build,
                                    const TreeCacheSettings& cache, TreeCacheOutcome& outcome);

/// Settings for each pair of shapes.
struct TrialSettings {
  std::vector<simulation::NamedContactModel> models;
  std::vector<simulation::ProbeLevel> levels;
  std::string half = "report";  ///< tune, report or all
  std::size_t touches = 100;
  oracle::ThrowOptions throws;
  double dt_s = 1.0 / 60;  ///< of the step that gives the results
};

/// Throws two shapes at each other. Adds one pair, and one row for each model and level, to the document. Contacts are
/// distributed over the executor; the figures do not depend on it, except times. Refused: a pair that never touches; a
/// request to stop.
Status try_pair(const TrialShape& a, const TrialShape& b, const TrialSettings& settings, parallel::Executor& executor,
                const std::stop_token& stop, io::LevelsDocument& document);

/// Mean, median and 90th percentile (nearest rank) of the values as shares of `whole`; all 0 if that is 0. `values`
/// must not be empty.
io::ErrorSpread spread_of(std::vector<double> values, double whole);

}  // namespace poise::app
