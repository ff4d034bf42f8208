// SPDX-License-Identifier: MIT
#include "app/sweep/slurm_engine.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <system_error>

#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/sweep/trial_runner.h"
#include "poise/step.h"
#include "scene/result_file.h"
#include "sweep/slurm_array.h"
#include "sweep/trial_batch.h"

namespace poise::app {
namespace {

namespace fs = std::filesystem;

/// So long no array must be active before the wait is over: squeue leaves out a task for a moment while it is put back
/// into the queue, and a shared file system may show a new file late.
constexpr double kSurelyOver_s = 3;
constexpr double kShortestLook_s = 0.3, kLongestLook_s = 10;

/// Sleeps, or until a signal.
void pause(double seconds, const parallel::Interrupt& interrupt) {
  const auto until =
      SteadyClock::now() + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(seconds));
  while (!interrupt.asked() && SteadyClock::now() < until) ::poll(nullptr, 0, 50);
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

/// The folders of the sweep's job arrays.
fs::path arrays_folder(const sweep::TrialStore& store) { return store.folder() / "slurm"; }

Status submit(const SweepPlan& plan, const sweep::TrialBatch& batch, const sweep::TrialStore& store,
              const SweepOptions& options, ActiveArrays& active) {
  const Result<fs::path> folder = new_array_folder(arrays_folder(store));
  if (!folder) return folder.error();
  std::error_code failure;
  const std::string program = fs::read_symlink("/proc/self/exe", failure).string();
  const std::string file = (folder.value() / "batch.json").string();
  sweep::SlurmArray array;
  array.name = "poise-" + plan.spec.name;
  array.folder = folder.value().string();
  array.command = {program, "sweep", "--batch", file, "--out", store.folder().string()};
  array.tasks = batch.tasks();
  array.cores = batch.trials.front().cores;
  array.task_limit_s = task_limit_s(batch);
  const Status written = io::write_file(file, sweep::batch_json(batch));
  if (!written) {
    fs::remove_all(folder.value(), failure);
    return written;
  }
  const Result<SubmittedArray> submitted = submit_array(array, options.slurm);
  if (!submitted) return submitted.error();
  active.arrays.push_back(submitted.value());
  for (const sweep::Trial& trial : batch.trials) active.keys.insert(trial.key);
  print_error("poise sweep: job array {} of {} tasks, {} trials each at most; its logs: {}\n", submitted.value().job,
              batch.tasks(), batch.per_task, array.folder);
  return Done{};
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
  for (const SubmittedArray& array : arrays_in_queue(arrays_folder(store))) {
    active.arrays.push_back(array);
    const Result<sweep::TrialBatch> batch = sweep::read_batch(array.folder / "batch.json");
    if (!batch) continue;
    for (const sweep::Trial& trial : batch.value().trials) active.keys.insert(trial.key);
  }
  return active;
}

Status submit_arrays(const SweepPlan& plan, const std::vector<sweep::Trial>& pending, const sweep::TrialStore& store,
                     const SweepOptions& options, ActiveArrays& active) {
  const std::uint64_t site = site_array_size();
  const std::uint64_t most = std::min(options.most_tasks.value_or(site), site);
  for (const sweep::TrialBatch& batch : sweep::slurm_batches(pending, most, options.slurm.exclusive)) {
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
    if (std::ranges::any_of(active.arrays, [](const SubmittedArray& array) { return in_queue(array.job); })) {
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
  print_error("poise sweep: task {}: {} done, {} failed, {} past their time limit\n", *options.task, result.done,
              result.failed, result.timed_out);
  return exit_code;
}

}  // namespace poise::app
