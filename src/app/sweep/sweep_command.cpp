// SPDX-License-Identifier: MIT
#include "app/sweep/sweep_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/capture/run_capture.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/report/figures_page.h"
#include "app/sweep/folder_lock.h"
#include "app/sweep/slurm_engine.h"
#include "app/sweep/slurm_jobs.h"
#include "app/sweep/sweep_options.h"
#include "app/sweep/sweep_plan.h"
#include "app/sweep/sweep_report.h"
#include "app/sweep/sweep_text.h"
#include "app/sweep/trial_runner.h"
#include "parallel/interrupt.h"
#include "scene/made_by.h"
#include "scene/result_file.h"
#include "sweep/frontier.h"
#include "sweep/results.h"

namespace poise::app {
namespace {

namespace fs = std::filesystem;
using sweep::TrialState;

/// Trials that the engine has to run.
std::vector<sweep::Trial> pending_trials(const SweepPlan& plan, const sweep::TrialStore& store, bool retry_failed) {
  std::vector<sweep::Trial> pending;
  for (const sweep::Trial& trial : plan.trials) {
    const TrialState state = store.outcome_of(trial).state;
    const bool again = retry_failed && (state == TrialState::Failed || state == TrialState::TimedOut);
    if (state == TrialState::Pending || again) pending.push_back(trial);
  }
  return pending;
}

/// How many trials run at the same time.
RunnerSettings runner_settings(const SweepOptions& options) {
  RunnerSettings runner;
  runner.processors = own_processors();
  runner.workers = options.workers.value_or(runner.processors.size());
  runner.share = options.workers.has_value();
  return runner;
}

/// Refused: a trial by the wall clock that needs more processors than there are.
Status check_cores(const std::vector<sweep::Trial>& trials, const RunnerSettings& runner) {
  for (const sweep::Trial& trial : trials) {
    if (trial.timed && trial.cores > runner.processors.size())
      return bad_input(fmt::format("{}: needs {} processors, and this process may use {}; see trial.cores and threads",
                                   trial.label, trial.cores, runner.processors.size()));
  }
  return Done{};
}

/// The page, its curves and its heat maps.
Status write_report(const SweepOptions& options, const SweepPlan& plan, const sweep::Results& results,
                    const std::vector<sweep::Group>& groups, FiguresFiles& report) {
  const FiguresDocument page = sweep_figures(plan.spec, results, groups, command_line());
  Status written = report.write(page);
  for (const DrawnPicture& picture : page.pictures) {
    const std::string name = fmt::format("heat-map-{}.svg", picture_name(picture.title));
    add_failure(io::write_file(fs::path(options.report) / name, picture.bytes), written);
  }
  return written;
}

/// CSV, database, page and table of what is there.
Status write_joined(const SweepOptions& options, const SweepPlan& plan, const sweep::TrialStore& store,
                    std::optional<FiguresFiles>& report, sweep::StateCounts& counts) {
  const Result<sweep::Results> results = sweep::join(plan.spec, plan.trials, store);
  if (!results) return results.error();
  counts = sweep::count_states(results.value());
  const std::vector<sweep::Group> groups = sweep::groups_of(plan.spec, results.value());
  Status written = io::write_file(store.folder() / "trials.csv", sweep::results_csv(plan.spec, results.value()));
  const Result<std::string> database = sweep::results_sqlite(plan.spec, results.value());
  add_failure(database ? io::write_file(store.folder() / "sweep.sqlite", database.value()) : Status(database.error()),
              written);
  if (report) add_failure(write_report(options, plan, results.value(), groups, *report), written);
  if (!options.quiet) {
    std::string text = result_text(plan.spec, counts, groups);
    if (written) text += fmt::format("results: {}, sweep.sqlite\n", (store.folder() / "trials.csv").string());
    if (written && report) text += fmt::format("report:  {}\n", (fs::path(options.report) / "report.html").string());
    add_failure(io::write_stdout(text), written);
  }
  return written;
}

int show_plan(const SweepPlan& plan, const sweep::TrialStore& store, const SweepOptions& options) {
  const std::vector<sweep::Trial> pending = pending_trials(plan, store, options.retry_failed);
  const RunnerSettings runner = runner_settings(options);
  const Status fits = options.engine == "local" ? check_cores(pending, runner) : Status(Done{});
  if (!fits) return refuse("sweep", fits.error());
  const Status shown = io::write_stdout(plan_text(plan, store, pending, options, runner));
  return shown ? kExitDone : refuse("sweep", shown.error());
}

/// What an engine came to.
struct EngineResult {
  Status status = Done{};
  bool stopped = false;
  std::string left;  ///< what is said when it was stopped
};

/// Refused: an engine that cannot begin, before anything of this folder is touched.
Status check_engine(const SweepOptions& options, const sweep::TrialStore& store) {
  if (options.engine == "slurm") return check_slurm();
  const ActiveArrays active = active_arrays(store);
  if (active.arrays.empty()) return Done{};
  return bad_input(fmt::format("job array {} of this folder is not over: wait for it, or end it with scancel {}",
                               active.arrays.front().job, active.arrays.front().job));
}

EngineResult run_locally(const SweepOptions& options, const std::vector<sweep::Trial>& pending,
                         const sweep::TrialStore& store, const parallel::Interrupt& interrupt, Progress& progress) {
  // Nobody else writes here now.
  store.clear_work();
  const RunnerResult run = run_trials(pending, store, runner_settings(options), interrupt, progress);
  return {run.stored, run.stopped, "the same command goes on where this one ended"};
}

EngineResult run_by_slurm(const SweepOptions& options, const SweepPlan& plan, std::vector<sweep::Trial> pending,
                          const sweep::TrialStore& store, const parallel::Interrupt& interrupt, Progress& progress) {
  ActiveArrays active = active_arrays(store);
  const std::vector<sweep::Trial> all = pending;
  std::erase_if(pending, [&](const sweep::Trial& trial) { return active.keys.contains(trial.key); });
  EngineResult result;
  if (!pending.empty()) result.status = submit_arrays(plan, pending, store, options, active);
  if (!result.status || options.no_wait) return result;
  result.stopped = wait_for_arrays(plan, all, store, active, interrupt, progress);
  result.left = "the job arrays go on; the same command joins their results";
  return result;
}

EngineResult run_pending(const SweepOptions& options, const SweepPlan& plan, const std::vector<sweep::Trial>& pending,
                         const sweep::TrialStore& store, const parallel::Interrupt& interrupt, Progress& progress) {
  if (options.no_run || pending.empty()) return {};
  const Status ready = check_engine(options, store);
  if (!ready) return {ready, false, {}};
  // What was there of trials that are run again must not be taken for what they come to now.
  for (const sweep::Trial& trial : pending) {
    if (store.outcome_of(trial).state != TrialState::Pending) store.forget(trial.key);
  }
  return options.engine == "slurm" ? run_by_slurm(options, plan, pending, store, interrupt, progress)
                                   : run_locally(options, pending, store, interrupt, progress);
}

int run_sweep(const SweepOptions& options) {
  const Status sound = check_sweep_options(options);
  if (!sound) return refuse("sweep", kExitBadUsage, sound.error().message);
  if (!options.batch.empty()) return run_slurm_task(options);
  std::vector<std::string> errors;
  const Result<SweepPlan> plan = plan_sweep(options.spec, errors);
  for (const std::string& error : errors) refuse("sweep", kExitBadInput, error);
  if (!plan) return errors.empty() ? refuse("sweep", plan.error()) : exit_code_of(plan.error());
  const sweep::TrialStore store(sweep_folder(options));
  if (options.dry_run) return show_plan(plan.value(), store, options);
  const parallel::Interrupt interrupt;
  const Status made = store.make();
  if (!made) return refuse("sweep", made.error());
  // Two calls at once would run the same trials twice, and each would take the other's cores for free ones. One that
  // only joins may look at another's results.
  std::optional<FolderLock> lock;
  if (!options.no_run) {
    Result<FolderLock> taken = FolderLock::take(store.folder());
    if (!taken) return refuse("sweep", taken.error());
    lock.emplace(std::move(taken).value());
  }
  std::optional<FiguresFiles> report;
  if (!options.report.empty()) {
    Result<FiguresFiles> opened = FiguresFiles::open(options.report);
    if (!opened) return refuse("sweep", opened.error());
    report.emplace(std::move(opened).value());
  }
  const std::vector<sweep::Trial> pending = pending_trials(plan.value(), store, options.retry_failed);
  if (options.engine == "local" && !options.no_run) {
    const Status fits = check_cores(pending, runner_settings(options));
    if (!fits) return refuse("sweep", fits.error());
  }
  Progress progress(!options.quiet);
  const EngineResult ran = run_pending(options, plan.value(), pending, store, interrupt, progress);
  progress.end();
  sweep::StateCounts counts;
  Status written = write_joined(options, plan.value(), store, report, counts);
  Status all = ran.status;
  add_failure(written, all);
  if (!all) return refuse("sweep", all.error());
  if (ran.stopped) return refuse("sweep", stopped_error(ran.left));
  if (counts.pending > 0 && !options.no_run && !options.no_wait)
    return refuse(
        "sweep", kExitRequirementFailed,
        fmt::format("{} trials have no result: their process or task was ended, or the array cancelled; the "
                    "same command runs them again{}",
                    counts.pending,
                    options.engine == "slurm" ? fmt::format("; logs of tasks are in {}/slurm", sweep_folder(options))
                                              : std::string()));
  return counts.failed + counts.timed_out > 0 ? kExitRequirementFailed : kExitDone;
}

}  // namespace

void add_sweep_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SweepOptions>();
  CLI::App* command = app.add_subcommand("sweep", "Run many runs that a specification names, and join their results");
  add_sweep_options(*command, *options);
  command->footer(
      "Examples:\n"
      "  poise sweep frontier.json --dry-run\n"
      "  poise sweep frontier.json --report out   and the same again, to go on where it was ended\n"
      "  poise sweep frontier.json --engine slurm --exclusive --partition compute\n\n"
      "Exit codes: 0 all trials are done, 1 trials failed, were ended at their time limit or have no result (with "
      "--no-run and --no-wait they may be missing yet: 0), 2 bad "
      "usage, 3 bad input, 4 output failed, 130 stopped by Ctrl-C, 143 by SIGTERM.");
  command->callback([options, &exit_code] { exit_code = run_sweep(*options); });
}

}  // namespace poise::app
