// SPDX-License-Identifier: MIT
#include "app/sweep/job_array_command.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/sweep/slurm_jobs.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

struct JobArrayOptions {
  std::string folder;  ///< of the folders of arrays
  std::string name;    ///< of the job; empty: none is submitted
  std::optional<std::uint64_t> tasks, cores, task_limit_s;
  SlurmOptions slurm;
  std::vector<std::string> command;
};

int submit(const JobArrayOptions& options) {
  const Status there = check_slurm();
  if (!there) return refuse("tune", there.error());
  const std::uint64_t tasks = options.tasks.value_or(1), most = site_array_size();
  if (tasks > most)
    return refuse("tune", kExitBadUsage,
                  fmt::format("--workers = {}, must be at most {}: MaxArraySize of this site", tasks, most));
  const Result<std::filesystem::path> folder = new_array_folder(options.folder);
  if (!folder) return refuse("tune", folder.error());
  sweep::SlurmArray array;
  array.name = options.name;
  array.folder = folder.value().string();
  array.command = options.command;
  array.tasks = tasks;
  array.cores = options.cores.value_or(1);
  array.task_limit_s = static_cast<double>(options.task_limit_s.value_or(3600));
  const Result<SubmittedArray> submitted = submit_array(array, options.slurm);
  if (!submitted) return refuse("tune", submitted.error());
  print_error("poise tune: job array {} of {} workers; their logs: {}\n", submitted.value().job, tasks, array.folder);
  return kExitDone;
}

int show_queue(const JobArrayOptions& options) {
  std::string text;
  for (const SubmittedArray& array : arrays_in_queue(options.folder)) text += fmt::format("{}\n", array.job);
  const Status written = io::write_stdout(text);
  return written ? kExitDone : refuse("tune", written.error());
}

}  // namespace

void add_job_array_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<JobArrayOptions>();
  // Without a group it is in no help.
  CLI::App* command = app.add_subcommand("job-array", "Job arrays of the workers of a search")->group("");
  add_path(*command, "--folder", options->folder, "Folder of the folders of arrays")->required();
  command->add_option("--submit", options->name, "Submit an array of this name");
  add_whole(*command, "--tasks", options->tasks, 1, 1'000'000, "Its tasks");
  add_whole(*command, "--cores", options->cores, 1, 4096, "Processors of a task");
  add_whole(*command, "--task-limit-s", options->task_limit_s, 1, 100'000'000, "Time limit of a task");
  add_slurm_options(*command, options->slurm);
  command->add_option("COMMAND", options->command, "What a task runs, behind --");
  command->callback(
      [options, &exit_code] { exit_code = options->name.empty() ? show_queue(*options) : submit(*options); });
}

}  // namespace poise::app
