// SPDX-License-Identifier: MIT
#include "sweep/slurm_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

namespace poise::sweep {
namespace {

/// The whole number that a text begins with, and what follows it.
std::optional<std::uint64_t> leading_number(std::string_view text, std::string_view& rest) {
  std::uint64_t value = 0;
  const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{}) return std::nullopt;
  rest = text.substr(static_cast<std::size_t>(stop - text.data()));
  return value;
}

}  // namespace

std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=:,+@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos) return std::string(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::uint64_t slurm_minutes(double task_limit_s) {
  return static_cast<std::uint64_t>(std::ceil(std::clamp(task_limit_s, 0.0, 1e9) / 60)) + 1;
}

std::string slurm_script(const SlurmArray& array) {
  std::string script = fmt::format(
      "#!/bin/sh\n"
      "#SBATCH --nodes=1\n"
      "#SBATCH --ntasks=1\n"
      "#SBATCH --array=0-{}{}\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --time={}\n"
      "#SBATCH --requeue\n"
      "#SBATCH --open-mode=append\n",
      array.tasks - 1, array.tasks_at_once > 0 ? fmt::format("%{}", array.tasks_at_once) : "", array.cores,
      slurm_minutes(array.task_limit_s));
  if (array.exclusive) script += "#SBATCH --exclusive\n";
  // Since Slurm 22.05 srun does not take the number of processors from the job.
  script += fmt::format("exec srun --ntasks=1 --cpus-per-task={} --cpu-bind=cores", array.cores);
  for (const std::string& word : array.command) script += " " + shell_word(word);
  return script + " --task \"$SLURM_ARRAY_TASK_ID\"\n";
}

std::optional<std::uint64_t> max_array_size(std::string_view config) {
  constexpr std::string_view kName = "MaxArraySize";
  const std::size_t at = config.find(kName);
  if (at == std::string_view::npos) return std::nullopt;
  const std::size_t value = config.find_first_not_of(" \t=", at + kName.size());
  if (value == std::string_view::npos) return std::nullopt;
  std::string_view rest;
  return leading_number(config.substr(value), rest);
}

std::optional<std::uint64_t> submitted_job(std::string_view output) {
  std::string_view rest;
  const std::optional<std::uint64_t> job = leading_number(output, rest);
  return rest.empty() || rest[0] == '\n' || rest[0] == ';' ? job : std::nullopt;
}

std::vector<TrialBatch> slurm_batches(const std::vector<Trial>& pending, std::uint64_t most_tasks, bool exclusive) {
  std::map<std::uint64_t, TrialBatch> by_cores;
  for (const Trial& trial : pending) by_cores[trial.cores].trials.push_back(trial);
  std::vector<TrialBatch> batches;
  for (auto& [cores, batch] : by_cores) {
    batch.per_task = trials_per_task(batch.trials.size(), most_tasks);
    batch.exclusive = exclusive;
    batches.push_back(std::move(batch));
  }
  return batches;
}

}  // namespace poise::sweep
