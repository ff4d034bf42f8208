// SPDX-License-Identifier: MIT
#include "app/sweep/sweep_options.h"

#include <filesystem>

#include "app/options/option_values.h"
#include "app/options/suggestions.h"

namespace poise::app {

void add_sweep_options(CLI::App& command, SweepOptions& options) {
  // Not required by the parser: a task of the engine slurm has none.
  command.add_option("SPEC", options.spec, "The specification: a file, poise.sweep/1 (docs/sweep.md)")
      ->type_name("FILE");
  add_path(
      command, "--out", options.out,
      "Folder of results, logs, trials.csv and sweep.sqlite (default: the specification's name with .sweep, in the "
      "current folder)")
      ->type_name("DIR");
  command.add_flag("--dry-run", options.dry_run, "Show the trials and the time that they need, and start none");
  command.add_flag("--no-run", options.no_run, "Start nothing: join the results that are there");
  command.add_flag("--retry-failed", options.retry_failed,
                   "Run trials again that failed or were ended at their time limit");
  add_path(command, "--report", options.report,
           "Write a page into this folder: curves along the axes, the frontier, heat maps; all pictures as SVG too")
      ->type_name("DIR");
  command
      .add_option("--engine", options.engine,
                  "local: processes on this machine; slurm: a job array by sbatch (default local)")
      ->check(one_of({"local", "slurm"}))
      ->type_name("ENGINE");
  add_whole(command, "--workers", options.workers, 1, 256,
            "Trials at the same time on this machine (default: as many as have processors of their own; with more, "
            "trials that count work share them)");
  add_slurm_options(command, options.slurm);
  add_whole(command, "--max-tasks", options.most_tasks, 1, 1'000'000,
            "slurm: tasks of an array, at most (default: what the site permits, MaxArraySize)");
  command.add_flag("--no-wait", options.no_wait, "slurm: submit and return; the same command later joins the results");
  command.add_flag("--quiet", options.quiet, "No progress and no table");
  command.add_option("--batch", options.batch)->group("");
  add_whole(command, "--task", options.task, 0, 10'000'000, "")->group("");
}

Status check_sweep_options(const SweepOptions& options) {
  if (options.batch.empty() != !options.task) return bad_input("--batch and --task need each other");
  if (!options.batch.empty()) {
    if (!options.spec.empty() || options.out.empty()) return bad_input("--batch takes --out and no SPEC");
    return Done{};
  }
  if (options.spec.empty()) return bad_input("SPEC is required: the file of a specification (docs/sweep.md)");
  if (options.spec == "-") return bad_input("SPEC = -, must be a file: what it names is relative to its folder");
  if (options.report == "-" || options.out == "-") return bad_input("--out and --report must be folders");
  if (options.dry_run && options.no_run) return bad_input("--dry-run has no meaning with --no-run");
  if (options.dry_run && !options.report.empty()) return bad_input("--report has no meaning with --dry-run");
  if (options.retry_failed && options.no_run) return bad_input("--retry-failed has no meaning with --no-run");
  const bool slurm = options.engine == "slurm";
  if (slurm && options.workers) return bad_input("--workers has no meaning with --engine slurm; see --tasks-at-once");
  if (slurm) return Done{};
  const char* of_slurm = options.slurm.exclusive            ? "--exclusive"
                         : options.no_wait                  ? "--no-wait"
                         : !options.slurm.partition.empty() ? "--partition"
                         : !options.slurm.sbatch.empty()    ? "--sbatch"
                         : options.most_tasks               ? "--max-tasks"
                         : options.slurm.tasks_at_once      ? "--tasks-at-once"
                                                            : nullptr;
  if (of_slurm != nullptr) return bad_input(std::string(of_slurm) + " needs --engine slurm");
  return Done{};
}

std::string sweep_folder(const SweepOptions& options) {
  const std::filesystem::path folder =
      options.out.empty() ? std::filesystem::path(options.spec).stem().string() + ".sweep" : options.out;
  std::error_code none;
  const std::filesystem::path absolute = std::filesystem::absolute(folder, none);
  return absolute.empty() ? folder.string() : absolute.lexically_normal().string();
}

}  // namespace poise::app
