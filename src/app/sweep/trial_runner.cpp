// SPDX-License-Identifier: MIT
#include "app/sweep/trial_runner.h"

#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "app/process/exit_codes.h"
#include "app/process/standard_streams.h"
#include "app/sweep/child_process.h"
#include "poise/step.h"
#include "sweep/core_map.h"

namespace poise::app {
namespace {

namespace fs = std::filesystem;

/// So often a signal is looked for while trials run. Where the system has no descriptors of processes, their end is
/// too.
constexpr int kLookMs = 100;
constexpr int kLookForEndMs = 5;
constexpr std::size_t kToldLines = 3;

struct Running {
  const sweep::Trial* trial = nullptr;
  ChildProcess process;
  std::vector<int> processors;
  fs::path work_file;
  SteadyClock::time_point begin;
};

double seconds_since(SteadyClock::time_point begin) {
  return std::chrono::duration<double>(SteadyClock::now() - begin).count();
}

/// The state of one call of run_trials.
class Runner {
 public:
  Runner(const std::vector<sweep::Trial>& trials, const sweep::TrialStore& store, const RunnerSettings& settings)
      : trials_(trials),
        store_(store),
        settings_(settings),
        cores_(settings.processors),
        host_(host_name()),
        writer_(fmt::format("{}.{}", host_, ::getpid())) {}

  RunnerResult run(const parallel::Interrupt& interrupt, Progress& progress) {
    while (result_.stored && (next_ < trials_.size() || !running_.empty())) {
      if (interrupt.asked()) {
        result_.stopped = true;
        break;
      }
      start_what_fits();
      progress.share(text(), share());
      wait();
      collect(progress);
    }
    // What still runs is ended, and its unfinished files removed.
    for (Running& running : running_) {
      running.process.end();
      remove(running.work_file);
    }
    return result_;
  }

 private:
  std::optional<std::vector<int>> processors_for(const sweep::Trial& trial) {
    if (!settings_.bind) return running_.empty() ? std::optional<std::vector<int>>(std::in_place) : std::nullopt;
    using Use = sweep::CoreMap::Use;
    return cores_.take(trial.cores, trial.timed ? Use::Alone : settings_.share ? Use::Shared : Use::Unused);
  }

  void start_what_fits() {
    while (result_.stored && next_ < trials_.size() && running_.size() < settings_.workers) {
      const sweep::Trial& trial = trials_[next_];
      const std::optional<std::vector<int>> processors = processors_for(trial);
      if (!processors) return;
      ++next_;
      const fs::path work_file = store_.work_file(trial.key, writer_);
      const SteadyClock::time_point begin = SteadyClock::now();
      Result<ChildProcess> started =
          ChildProcess::start(sweep::trial_words(trial, work_file.string()), store_.log_file(trial.key), *processors);
      if (!started) {
        result_.stored = started.error();
        return;
      }
      running_.push_back({&trial, std::move(started).value(), *processors, work_file, begin});
    }
  }

  /// Until a trial is over or at its time limit, or it is time to look for signals.
  void wait() {
    std::vector<pollfd> ends;
    double wait_s = kLookMs / 1e3;
    for (const Running& running : running_) {
      if (running.process.descriptor() < 0) wait_s = std::min(wait_s, kLookForEndMs / 1e3);
      ends.push_back({running.process.descriptor(), POLLIN, 0});
      wait_s = std::min(wait_s, running.trial->time_limit_s - seconds_since(running.begin));
    }
    // Up to the next whole millisecond, so that a limit has passed when it is looked at.
    if (!ends.empty()) ::poll(ends.data(), ends.size(), static_cast<int>(std::max(0.0, wait_s) * 1e3) + 1);
  }

  void collect(Progress& progress) {
    for (std::size_t i = 0; i < running_.size() && result_.stored;) {
      Running& running = running_[i];
      const bool over = running.process.over();
      const double seconds = seconds_since(running.begin);
      const bool late = !over && seconds >= running.trial->time_limit_s;
      if (!over && !late) {
        ++i;
        continue;
      }
      if (late) running.process.end();
      finish(running, seconds, late, progress);
      if (settings_.bind) cores_.give_back(running.processors);
      running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  void finish(const Running& running, double seconds, bool late, Progress& progress) {
    using State = sweep::TrialState;
    const sweep::Trial& trial = *running.trial;
    const int code = running.process.exit_code();
    const bool ended_from_outside = !late && (code == 128 + SIGTERM || code == 128 + SIGINT);
    std::error_code none;
    if (ended_from_outside) {
      // Whoever ends a whole group of processes ends this one too: it is no fault of the trial.
      remove(running.work_file);
      progress.end();
      print_error("poise sweep: {}: was ended by a signal from outside; it is run again by the next call\n",
                  trial.label);
      return;
    }
    if (code == ChildProcess::kNotStarted) {
      result_.stored = bad_input("/proc/self/exe: cannot be started as the program of a trial");
      return;
    }
    const bool complete = code == kExitDone && fs::exists(running.work_file, none);
    if (!late && code == kExitOutputFailed) {
      const std::vector<std::string> log = sweep::log_tail(store_.log_file(trial.key), 1);
      result_.stored = Error{ErrorKind::OutputFailed, log.empty() ? "a result could not be written" : log.back()};
      return;
    }
    sweep::Outcome outcome;
    outcome.state = late ? State::TimedOut : complete ? State::Done : State::Failed;
    outcome.exit_code = code;
    outcome.seconds = seconds;
    outcome.time_limit_s = trial.time_limit_s;
    outcome.host = host_;
    outcome.engine = settings_.engine;
    outcome.affinity = running.processors;
    result_.stored = store_.store(trial, outcome, running.work_file);
    if (!result_.stored) return;
    result_.done += complete ? 1 : 0;
    result_.timed_out += late ? 1 : 0;
    result_.failed += !complete && !late ? 1 : 0;
    if (complete) {
      if (fs::file_size(store_.log_file(trial.key), none) == 0) remove(store_.log_file(trial.key));
      return;
    }
    remove(running.work_file);
    progress.end();
    tell_failure(trial, outcome, store_);
  }

  static void remove(const fs::path& file) {
    std::error_code none;
    fs::remove(file, none);
  }

  [[nodiscard]] double share() const {
    return static_cast<double>(next_ - running_.size()) / static_cast<double>(std::max<std::size_t>(1, trials_.size()));
  }
  [[nodiscard]] std::string text() const {
    std::string line = fmt::format("{} of {} trials", next_ - running_.size(), trials_.size());
    if (result_.failed > 0) line += fmt::format(", {} failed", result_.failed);
    if (result_.timed_out > 0) line += fmt::format(", {} past their time limit", result_.timed_out);
    if (!running_.empty()) line += "; now " + running_.back().trial->label;
    return line;
  }

  const std::vector<sweep::Trial>& trials_;
  const sweep::TrialStore& store_;
  const RunnerSettings& settings_;
  sweep::CoreMap cores_;
  std::string host_, writer_;
  std::vector<Running> running_;
  std::size_t next_ = 0;
  RunnerResult result_;
};

}  // namespace

std::vector<int> own_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> processors;
  if (::sched_getaffinity(0, sizeof(set), &set) == 0) {
    for (int processor = 0; processor < CPU_SETSIZE; ++processor) {
      if (CPU_ISSET(static_cast<std::size_t>(processor), &set)) processors.push_back(processor);
    }
  }
  return processors.empty() ? std::vector<int>{0} : processors;
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0' ? name.data() : "unknown";
}

void tell_failure(const sweep::Trial& trial, const sweep::Outcome& outcome, const sweep::TrialStore& store) {
  const std::string what = outcome.state == sweep::TrialState::TimedOut
                               ? fmt::format("was ended at its time limit of {:g} s", outcome.time_limit_s)
                           : outcome.exit_code > 128 ? fmt::format("was ended by signal {}", outcome.exit_code - 128)
                                                     : fmt::format("failed with exit code {}", outcome.exit_code);
  print_error("poise sweep: {}: {}; its log: {}\n", trial.label, what, store.log_file(trial.key).string());
  for (const std::string& line : sweep::log_tail(store.log_file(trial.key), kToldLines)) print_error("    {}\n", line);
}

RunnerResult run_trials(const std::vector<sweep::Trial>& trials, const sweep::TrialStore& store,
                        const RunnerSettings& settings, const parallel::Interrupt& interrupt, Progress& progress) {
  return Runner(trials, store, settings).run(interrupt, progress);
}

}  // namespace poise::app
