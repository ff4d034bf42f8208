// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sweep/results.h"

namespace poise::sweep {

/// All trials that differ in seed and repeat alone.
struct Group {
  std::string scene;
  std::vector<Setting> settings;                 ///< without the seed, where that is an axis
  std::size_t pending = 0, done = 0, ended = 0;  ///< trials; `ended`: failed, or ended at their time limit
  /// Of each of Results::figures, over the trials that are done; empty where one of them does not define it.
  std::vector<std::optional<double>> mean, least, most;
  /// Whether the requirements hold for the means of the figures. False too where a trial failed or was ended; empty
  /// where a trial is pending, or there are no requirements.
  std::optional<bool> holds;
};

/// The groups of a sweep, in the order of their first trials.
std::vector<Group> groups_of(const SweepSpec& spec, const Results& results);

/// The value of a setting of a group as text, empty if it has none of this name.
std::string value_of(const Group& group, const std::string& name);

/// The frontier at one value of the axis `against`.
struct FrontierPoint {
  double at = 0;
  std::optional<double> largest;  ///< at which, and at all smaller values, the requirements hold; empty: at none
  bool open = false;              ///< the next larger value is not known to fail: it is pending, or there is none
};

/// The frontier for one combination of scene and all other axes.
struct FrontierLine {
  std::string label;                  ///< what it is of, e.g. `jacks, threads=2`
  std::vector<FrontierPoint> points;  ///< by ascending `at`
};

/// Empty without a frontier in the specification.
std::vector<FrontierLine> frontier_of(const SweepSpec& spec, const std::vector<Group>& groups);

/// Scene and values of the axes but seed and those in `without`: `jacks, threads=2`. The scene is left out where the
/// sweep has one, unless nothing else is left.
std::string group_label(const SweepSpec& spec, const Group& group, const std::vector<std::string>& without);

}  // namespace poise::sweep
