// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sweep/trial_batch.h"

namespace poise::sweep {

/// What a job array is submitted with.
struct SlurmArray {
  std::string name;                  ///< of the job
  std::string folder;                ///< of its logs
  std::vector<std::string> command;  ///< of one task, without its number
  std::uint64_t tasks = 1;
  std::uint64_t cores = 1;          ///< of a task
  double task_limit_s = 3600;       ///< the time limits of a task's trials together
  bool exclusive = false;           ///< a task has its node to itself
  std::uint64_t tasks_at_once = 0;  ///< 0: as many as the site starts
};

/// A word as a POSIX shell reads it.
std::string shell_word(std::string_view word);

/// The script that sbatch gets. A task that lost its node is put into the queue again (--requeue), and skips trials
/// that have a result. srun binds it to its cores where the site can.
std::string slurm_script(const SlurmArray& array);

/// The time limit of a task as sbatch has it, in whole minutes: a minute more than its trials may take.
std::uint64_t slurm_minutes(double task_limit_s);

/// The value of MaxArraySize in what `scontrol show config` prints: numbers of tasks are below it. Empty: it is not
/// there.
std::optional<std::uint64_t> max_array_size(std::string_view config);

/// The job's number in what `sbatch --parsable` prints: `123` or `123;cluster`. Empty: neither.
std::optional<std::uint64_t> submitted_job(std::string_view output);

/// Pending trials as batches: one for each number of cores, of at most `most_tasks` tasks each.
std::vector<TrialBatch> slurm_batches(const std::vector<Trial>& pending, std::uint64_t most_tasks, bool exclusive);

}  // namespace poise::sweep
