// SPDX-License-Identifier: MIT
#include "app/sweep/slurm_engine.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <system_error>

#include "app/exit_codes.h"
#include "app/refusal.h"
#include "app/sweep/child_process.h"
#include "app/sweep/trial_runner.h"
#include "assets/files/text_file.h"
#include "poise/step.h"
#include "scene/result_file.h"
#include "sweep/slurm_array.h"
#include "sweep/trial_batch.h"

namespace poise::app {
namespace {

namespace fs = std::filesystem;

/// Slurm's own limit where `scontrol` does not tell it.
constexpr std::uint64_t kUsualArraySize = 1001;
/// So long no array must be active before the wait is over: squeue leaves out a task for a moment while it is put back
/// into the queue, and a shared file system may show a new file late.
constexpr double kSurelyOver_s = 3;
constexpr double kShortestLook_s = 0.3, kLongestLook_s = 10;

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// Sleeps, or until a signal.
void pause(double seconds, const parallel::Interrupt& interrupt) {
  const auto until =
      SteadyClock::now() + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(seconds));
  while (!interrupt.asked() && SteadyClock::now() < until) ::poll(nullptr, 0, 50);
}

/// Whether Slurm has still tasks of the array. It says that it does not know a job that ended some time ago. Where
/// there is no Slurm, as beside a copy of the folder, nothing is active.
bool is_active(std::uint64_t job) {
  const ProgramOutput said = run_program({"squeue", "--noheader", "--format=%i", fmt::format("--jobs={}", job)});
  if (said.exit_code == 0) return said.out.find_first_not_of(" \n") != std::string::npos;
  return said.exit_code != 127 && said.error.find("Invalid job id") == std::string::npos;
}

std::vector<fs::path> array_folders(const sweep::TrialStore& store) {
  std::vector<fs::path> folders;
  std::error_code failure;
  for (fs::directory_iterator entry(store.folder() / "slurm", failure), end; !failure && entry != end;
       entry.increment(failure))
    folders.push_back(entry->path());
  std::ranges::sort(folders);
  return folders;
}

/// A new folder slurm/001, slurm/002, ... of the sweep.
Result<fs::path> new_array_folder(const sweep::TrialStore& store) {
  const fs::path all = store.folder() / "slurm";
  std::error_code failure;
  fs::create_directories(all, failure);
  for (int number = 1; !failure && number < 100'000; ++number) {
    const fs::path folder = all / fmt::format("{:03}", number);
    // False if it was there: another call may take the same number.
    if (fs::create_directory(folder, failure)) return folder;
  }
  return Error{ErrorKind::OutputFailed, fmt::format("{}: cannot be written: {}", all.string(), failure.message())};
}

std::uint64_t site_array_size() {
  const ProgramOutput config = run_program({"scontrol", "show", "config"});
  return sweep::max_array_size(config.out).value_or(kUsualArraySize);
}

double task_limit_s(const sweep::TrialBatch& batch) {
  double longest = 0;
  for (std::uint64_t task = 0; task < batch.tasks(); ++task) {
    double sum = 0;
    for (const sweep::Trial& trial : batch.of_task(task)) sum += trial.time_limit_s;
    longest = std::max(longest, sum);
  }
  return longest;
}

Status submit(const SweepPlan& plan, const sweep::TrialBatch& batch, const sweep::TrialStore& store,
              const SweepOptions& options, ActiveArrays& active) {
  const Result<fs::path> folder = new_array_folder(store);
  if (!folder) return folder.error();
  std::error_code failure;
  const std::string program = fs::read_symlink("/proc/self/exe", failure).string();
  const std::string file = (folder.value() / "batch.json").string();
  const std::string script = (folder.value() / "task.sh").string();
  sweep::SlurmArray array;
  array.name = "poise-" + plan.spec.name;
  array.folder = folder.value().string();
  array.command = {program, "sweep", "--batch", file, "--out", store.folder().string()};
  array.tasks = batch.tasks();
  array.cores = batch.trials.front().cores;
  array.task_limit_s = task_limit_s(batch);
  array.exclusive = batch.exclusive;
  array.tasks_at_once = options.tasks_at_once.value_or(0);
  Status written = io::write_file(file, sweep::batch_json(batch));
  if (written) written = io::write_file(script, sweep::slurm_script(array));
  const auto refused = [&](const Error& error) {
    fs::remove_all(folder.value(), failure);
    return error;
  };
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
  active.arrays.push_back({*job, folder.value()});
  for (const sweep::Trial& trial : batch.trials) active.keys.insert(trial.key);
  fmt::print(stderr, "poise sweep: job array {} of {} tasks, {} trials each at most; its logs: {}\n", *job,
             batch.tasks(), batch.per_task, array.folder);
  return io::write_file(folder.value() / "job", fmt::format("{}\n", *job));
}

/// Tells of trials that have ended since the last call, and returns how many of all have.
std::size_t look_at(const std::vector<sweep::Trial>& trials, const sweep::TrialStore& store,
                    std::set<std::string>& ended, Progress& progress) {
  for (const sweep::Trial& trial : trials) {
    if (ended.contains(trial.key)) continue;
    const sweep::Outcome outcome = store.outcome_of(trial);
    if (outcome.state == sweep::TrialState::Pending) continue;
    ended.insert(trial.key);
    if (outcome.state == sweep::TrialState::Done) continue;
    progress.end();
    tell_failure(trial, outcome, store);
  }
  return ended.size();
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : value;
}

}  // namespace

ActiveArrays active_arrays(const sweep::TrialStore& store) {
  ActiveArrays active;
  for (const fs::path& folder : array_folders(store)) {
    const Result<std::string> text = geometry::read_bytes(folder / "job", 64);
    const std::optional<std::uint64_t> job = text ? sweep::submitted_job(text.value()) : std::nullopt;
    if (!job || !is_active(*job)) continue;
    active.arrays.push_back({*job, folder});
    const Result<sweep::TrialBatch> batch = sweep::read_batch(folder / "batch.json");
    if (!batch) continue;
    for (const sweep::Trial& trial : batch.value().trials) active.keys.insert(trial.key);
  }
  return active;
}

Status submit_arrays(const SweepPlan& plan, const std::vector<sweep::Trial>& pending, const sweep::TrialStore& store,
                     const SweepOptions& options, ActiveArrays& active) {
  const ProgramOutput version = run_program({"sbatch", "--version"});
  if (version.exit_code != 0)
    return bad_input("--engine slurm: sbatch cannot be started: " + first_line(version.error) +
                     "; run this on a login node of the cluster");
  const std::uint64_t site = site_array_size();
  const std::uint64_t most = std::min(options.most_tasks.value_or(site), site);
  for (const sweep::TrialBatch& batch : sweep::slurm_batches(pending, most, options.exclusive)) {
    const Status submitted = submit(plan, batch, store, options, active);
    if (!submitted) return submitted;
  }
  return Done{};
}

bool wait_for_arrays(const SweepPlan& plan, const std::vector<sweep::Trial>& pending, const sweep::TrialStore& store,
                     const ActiveArrays& active, const parallel::Interrupt& interrupt, Progress& progress) {
  std::set<std::string> ended;
  double look_s = kShortestLook_s;
  std::optional<SteadyClock::time_point> over;
  for (;;) {
    const std::size_t count = look_at(pending, store, ended, progress);
    progress.share(fmt::format("{} of {} trials of \"{}\" in {} job arrays", count, pending.size(), plan.spec.name,
                               active.arrays.size()),
                   static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, pending.size())));
    if (count == pending.size()) return false;
    if (std::ranges::any_of(active.arrays, [](const SubmittedArray& array) { return is_active(array.job); })) {
      over.reset();
    } else if (!over) {
      over = SteadyClock::now();
    }
    if (over && std::chrono::duration<double>(SteadyClock::now() - *over).count() > kSurelyOver_s) return false;
    if (interrupt.asked()) return true;
    pause(over ? kShortestLook_s : look_s, interrupt);
    look_s = std::min(kLongestLook_s, look_s * 1.2);
  }
}

int run_slurm_task(const SweepOptions& options) {
  const parallel::Interrupt interrupt;
  const Result<sweep::TrialBatch> batch = sweep::read_batch(options.batch);
  if (!batch) return refuse("sweep", batch.error());
  const Result<std::string> identity = program_identity();
  if (!identity) return refuse("sweep", identity.error());
  const sweep::TrialStore store(sweep_folder(options));
  int exit_code = kExitDone;
  std::vector<sweep::Trial> trials;
  for (const sweep::Trial& trial : batch.value().of_task(*options.task)) {
    // A task that is put into the queue again, or follows one that was lost, does the rest.
    if (store.outcome_of(trial).state != sweep::TrialState::Pending) continue;
    const Status unchanged = check_unchanged(trial, identity.value());
    if (unchanged) {
      trials.push_back(trial);
    } else {
      exit_code = refuse("sweep", unchanged.error());
    }
  }
  RunnerSettings runner;
  runner.processors = own_processors();
  // On a node that others use too, processors are chosen only where Slurm has chosen as many for this task.
  const std::uint64_t cores = trials.empty() ? 1 : trials.front().cores;
  runner.bind = runner.processors.size() >= cores && (batch.value().exclusive || runner.processors.size() == cores);
  runner.engine = fmt::format("slurm {}_{}", environment("SLURM_ARRAY_JOB_ID"), *options.task);
  Progress progress(false);
  const RunnerResult result = run_trials(trials, store, runner, interrupt, progress);
  if (!result.stored) return refuse("sweep", result.stored.error());
  if (result.stopped) return refuse("sweep", stopped_error("what has a result is done, the rest is pending"));
  fmt::print(stderr, "poise sweep: task {}: {} done, {} failed, {} past their time limit\n", *options.task, result.done,
             result.failed, result.timed_out);
  return exit_code;
}

}  // namespace poise::app
