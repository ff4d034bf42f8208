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

/// One figure of one case. For every figure with a bound, smaller is better.
struct Row {
  std::string case_name, figure, unit;  ///< the unit is "1" for shares and "" for counts
  double value = 0;
  std::optional<double> at_most;  ///< empty: reported only
  std::string published;          ///< published results of others, as text; empty if there are none
  /// Whether the value is finite and within its bound.
  [[nodiscard]] bool ok() const;
};

/// Drift and motion of a scene over time.
struct Series {
  std::string case_name;
  std::vector<double> time_s, drift_m, kinetic_j;
};

/// Input and output of a case. One thread.
struct Context {
  ExecutorKind executor = ExecutorKind::Serial;
  int threads = 1;
  std::uint64_t heaps = 12;      ///< that fall, where which heap it is decides what it does
  std::filesystem::path scenes;  ///< the folder of the shipped scene files; its accuracy/ has those of the cases
  std::optional<TreeCacheSettings> tree_cache;
  std::stop_token stop;
  std::function<void(double)> progress;  ///< called by long cases with the completed share, from 0 to 1; may be empty
  std::string case_name;                 ///< of the running case
  std::vector<Row> rows;
  std::vector<Series> series;

  void add(std::string figure, std::string unit, double value, std::optional<double> at_most,
           std::string published = "");
  /// Reports the completed share. Refused (Cancelled) after a request to stop.
  [[nodiscard]] Status at(double share) const;
  /// The settings of the study's Worlds.
  [[nodiscard]] WorldSettings world_settings() const;
};

/// One case of the study. run() is refused if a scene file cannot be read or after a request to stop. Errors of the
/// engine make rows that are not ok, never a refusal.
struct Case {
  std::string_view name;
  std::string_view expected;  ///< the expected result in closed form, for docs
  Status (*run)(Context&);
};

/// All cases in the order of the docs.
std::span<const Case> all_cases();

/// Whether `name` contains `pattern`, in which * matches any text; an empty pattern matches every name.
bool matches(std::string_view name, std::string_view pattern);

}  // namespace poise::accuracy
