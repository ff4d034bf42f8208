// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/sweep/slurm_jobs.h"
#include "poise/result.h"

namespace poise::app {

/// The command line of `poise sweep`, each value in its range, not yet checked against each other.
struct SweepOptions {
  std::string spec;
  std::string out;  ///< a folder; empty: the name of the specification with `.sweep`
  std::string engine = "local";
  std::string report;  ///< a folder
  bool dry_run = false, no_run = false, retry_failed = false, quiet = false;
  std::optional<std::uint64_t> workers;
  // Of the engine slurm.
  SlurmOptions slurm;
  bool no_wait = false;
  std::optional<std::uint64_t> most_tasks;
  // Of a task that the engine slurm started.
  std::string batch;
  std::optional<std::uint64_t> task;
};

/// Declares the options on a subcommand.
void add_sweep_options(CLI::App& command, SweepOptions& options);

/// Refused: options that contradict each other, as one line.
Status check_sweep_options(const SweepOptions& options);

/// The folder of results.
std::string sweep_folder(const SweepOptions& options);

}  // namespace poise::app
