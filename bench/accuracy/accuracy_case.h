// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "poise/assets/tree_cache.h"
#include "poise/result.h"
#include "poise/types.h"
#include "poise/world.h"

namespace poise::accuracy {

/// One figure of one case. Every figure that has a bound is made so that less is better.
struct Row {
  std::string case_name, figure, unit;  ///< the unit is "1" for shares and "" for counts
  double value = 0;
  std::optional<double> at_most;  ///< none: reported, not measured
  std::string published;          ///< what others reached, in words; empty where nothing was published
  /// Finite and within its bound.
  [[nodiscard]] bool ok() const;
};

/// How far a scene has drifted and how much it moves, over time.
struct Series {
  std::string case_name;
  std::vector<double> time_s, drift_m, kinetic_j;
};

/// What a case is given and where it leaves what it found. One thread.
struct Context {
  ExecutorKind executor = ExecutorKind::Serial;
  int threads = 1;
  std::filesystem::path scenes;  ///< the folder of the scene files that ship; its accuracy/ has those of the cases
  std::optional<TreeCacheSettings> tree_cache;
  std::stop_token stop;
  std::function<void(double)> progress;  ///< called with the share done, from 0 to 1, by the long ones; may be empty
  std::string case_name;                 ///< of the case that runs
  std::vector<Row> rows;
  std::vector<Series> series;

  void add(std::string figure, std::string unit, double value, std::optional<double> at_most,
           std::string published = "");
  /// Tells how much is done. Refused (Cancelled) once somebody asked to stop.
  [[nodiscard]] Status at(double share) const;
  /// What a World of the study starts from.
  [[nodiscard]] WorldSettings world_settings() const;
};

/// One case of the study. run() is refused where a scene file cannot be read or somebody asked to stop; what the engine
/// does wrong makes rows that are not ok and never a refusal.
struct Case {
  std::string_view name;
  std::string_view expected;  ///< what it says in the closed form, for docs
  Status (*run)(Context&);
};

/// All cases in the order of the docs.
std::span<const Case> all_cases();

/// Whether `name` contains `pattern`, in which * stands for anything; an empty pattern is in every name.
bool matches(std::string_view name, std::string_view pattern);

}  // namespace poise::accuracy
