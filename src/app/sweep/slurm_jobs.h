// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "poise/result.h"
#include "sweep/slurm_array.h"

namespace poise::app {

/// What a command line says of how job arrays are submitted.
struct SlurmOptions {
  bool exclusive = false;           ///< each task has its node to itself
  std::string partition;            ///< empty: the site's
  std::vector<std::string> sbatch;  ///< further options of sbatch
  std::optional<std::uint64_t> tasks_at_once;
};

/// Declares them on a subcommand.
void add_slurm_options(CLI::App& command, SlurmOptions& options);

/// A job array that was submitted, by this call or an earlier one.
struct SubmittedArray {
  std::uint64_t job = 0;
  std::filesystem::path folder;  ///< of its script, job number and logs
};

/// Refused: sbatch cannot be started here.
Status check_slurm();

/// What numbers of tasks must be below: MaxArraySize of the site, or Slurm's own default where it does not tell.
std::uint64_t site_array_size();

/// A new folder 001, 002, ... in `all`, which is made if it is not there. Refused: what cannot be written.
Result<std::filesystem::path> new_array_folder(const std::filesystem::path& all);

/// Writes the script of the array into its folder (array.folder, made by new_array_folder) and submits it; the file
/// `job` there has its number. Refused, and the folder removed: sbatch refuses, as it says; what cannot be written.
Result<SubmittedArray> submit_array(sweep::SlurmArray array, const SlurmOptions& options);

/// Whether Slurm still has tasks of the array. Where it does not answer, it has; where there is no Slurm, it has none.
bool in_queue(std::uint64_t job);

/// The arrays submitted in the folders of `all` that Slurm has not ended, by their folders.
std::vector<SubmittedArray> arrays_in_queue(const std::filesystem::path& all);

}  // namespace poise::app
