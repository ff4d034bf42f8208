// SPDX-License-Identifier: MIT
#include "app/sweep/slurm_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "app/options/option_values.h"
#include "app/process/refusal.h"
#include "app/sweep/child_process.h"
#include "assets/files/text_file.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

namespace fs = std::filesystem;

/// Slurm's own limit where `scontrol` does not tell it.
constexpr std::uint64_t kUsualArraySize = 1001;

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::vector<fs::path> array_folders(const fs::path& all) {
  std::vector<fs::path> folders;
  std::error_code failure;
  for (fs::directory_iterator entry(all, failure), end; !failure && entry != end; entry.increment(failure))
    folders.push_back(entry->path());
  std::ranges::sort(folders);
  return folders;
}

}  // namespace

void add_slurm_options(CLI::App& command, SlurmOptions& options) {
  command.add_flag("--exclusive", options.exclusive, "slurm: each task has its node to itself");
  command.add_option("--partition", options.partition, "slurm: the partition (default: the site's)")->type_name("P");
  command
      .add_option("--sbatch", options.sbatch,
                  "slurm: a further option of sbatch, as --sbatch=--account=me; may be given several times")
      ->allow_extra_args(false)
      ->type_name("OPTION");
  add_whole(command, "--tasks-at-once", options.tasks_at_once, 1, 1'000'000,
            "slurm: tasks that run at the same time, at most (default: as many as the site starts)");
}

Status check_slurm() {
  const ProgramOutput version = run_program({"sbatch", "--version"});
  if (version.exit_code == 0) return Done{};
  return bad_input("--engine slurm: sbatch cannot be started: " + first_line(version.error) +
                   "; run this on a login node of the cluster");
}

std::uint64_t site_array_size() {
  const ProgramOutput config = run_program({"scontrol", "show", "config"});
  return sweep::max_array_size(config.out).value_or(kUsualArraySize);
}

Result<fs::path> new_array_folder(const fs::path& all) {
  std::error_code failure;
  fs::create_directories(all, failure);
  for (int number = 1; !failure && number < 100'000; ++number) {
    const fs::path folder = all / fmt::format("{:03}", number);
    // False if it was there: another call may take the same number.
    if (fs::create_directory(folder, failure)) return folder;
  }
  return Error{ErrorKind::OutputFailed, fmt::format("{}: cannot be written: {}", all.string(), failure.message())};
}

Result<SubmittedArray> submit_array(sweep::SlurmArray array, const SlurmOptions& options) {
  const fs::path folder = array.folder;
  const std::string script = (folder / "task.sh").string();
  array.exclusive = options.exclusive;
  array.tasks_at_once = options.tasks_at_once.value_or(0);
  const auto refused = [&](const Error& error) {
    std::error_code none;
    fs::remove_all(folder, none);
    return error;
  };
  const Status written = io::write_file(script, sweep::slurm_script(array));
  if (!written) return refused(written.error());
  std::vector<std::string> words{"sbatch", "--parsable", "--job-name=" + array.name,
                                 "--output=" + array.folder + "/task-%a.log"};
  if (!options.partition.empty()) words.push_back("--partition=" + options.partition);
  words.insert(words.end(), options.sbatch.begin(), options.sbatch.end());
  words.push_back(script);
  const ProgramOutput said = run_program(words);
  const std::optional<std::uint64_t> job = sweep::submitted_job(said.out);
  if (said.exit_code != 0 || !job)
    return refused(bad_input("sbatch: " + first_line(said.error.empty() ? said.out : said.error)));
  const Status noted = io::write_file(folder / "job", fmt::format("{}\n", *job));
  if (!noted) {
    // Nobody would know of it.
    run_program({"scancel", fmt::format("{}", *job)});
    return refused(noted.error());
  }
  return SubmittedArray{*job, folder};
}

bool in_queue(std::uint64_t job) {
  const ProgramOutput said = run_program({"squeue", "--noheader", "--format=%i", fmt::format("--jobs={}", job)});
  if (said.exit_code == 0) return said.out.find_first_not_of(" \n") != std::string::npos;
  // It says that it does not know a job that ended some time ago.
  return said.exit_code != 127 && said.error.find("Invalid job id") == std::string::npos;
}

std::vector<SubmittedArray> arrays_in_queue(const fs::path& all) {
  std::vector<SubmittedArray> arrays;
  for (const fs::path& folder : array_folders(all)) {
    const Result<std::string> text = geometry::read_bytes(folder / "job", 64);
    const std::optional<std::uint64_t> job = text ? sweep::submitted_job(text.value()) : std::nullopt;
    if (job && in_queue(*job)) arrays.push_back({*job, folder});
  }
  return arrays;
}

}  // namespace poise::app
