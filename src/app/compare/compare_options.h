// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/compare/compare_loop.h"
#include "app/options/tree_cache_options.h"
#include "poise/result.h"

namespace poise::app {

/// The command line of `poise compare`, each value in its range, not yet checked against each other.
struct CompareOptions {
  std::string scene;
  std::string policies = "perceptual,random,fifo,size";
  std::string budgets;  ///< empty: kPercents or kMilliseconds, by the clock
  std::string clock = "work";
  std::string from;         ///< empty: no budget
  std::string from_policy;  ///< empty: that of the scene
  std::optional<std::uint64_t> frames, every, warmup, history, bodies, seed, threads;
  std::string json, csv, svg, report;
  TreeCacheOptions tree_cache;
  bool polygons = false;
  bool serve = false;
  bool quiet = false;
};

inline constexpr const char* kPercents = "0%,5%,10%,25%,50%";
inline constexpr const char* kMilliseconds = "1,2,4,8,16";

/// Declares the options on a subcommand.
void add_compare_options(CLI::App& command, CompareOptions& options);

/// The settings by the options; `policy` is that of the scene, whose weights all policies keep. Refused, as one line:
/// names, numbers and options that contradict each other.
Result<CompareSettings> compare_settings(const CompareOptions& options, const scheduler::Policy& policy);
/// Refuses an output into a file that the scene names.
Status check_compare_files(const CompareOptions& options, const Scene& scene);

/// A policy by its name, the oracle, or a policy file that is still to be read; it keeps the weights of `policy`.
/// Refused, without the option's name: anything else.
Result<Competitor> competitor_named(const std::string& name, const scheduler::Policy& policy);

/// Reads the policy file that a competitor is named for; it then has the name that the file gives. `errors` gets every
/// refusal, one line each.
Status read_policy_file(Competitor& competitor, std::vector<std::string>& errors);

/// Reads the policy files among the policies, which then have the names that the files give. `errors` gets every
/// refusal, one line each.
Status read_policy_files(CompareSettings& settings, std::vector<std::string>& errors);

}  // namespace poise::app
