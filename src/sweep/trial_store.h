// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "sweep/trial.h"

namespace poise::sweep {

/// How far a trial is.
enum class TrialState : std::uint8_t {
  Pending,   ///< it has no result, and is run by the next call
  Done,      ///< its `poise.run` JSON is there
  Failed,    ///< the run ended with an exit code other than 0 or by a signal
  TimedOut,  ///< it was ended at its time limit
};
/// `pending`, `done`, `failed` or `timed_out`.
const char* state_name(TrialState state);

/// How a trial ended, `poise.trial/1`.
struct Outcome {
  TrialState state = TrialState::Pending;
  int exit_code = 0;          ///< of the run; 128 + signal if a signal ended it
  double seconds = 0;         ///< from its start to its end
  double time_limit_s = 0;    ///< that it ran under
  std::string host;           ///< name of the machine
  std::string engine;         ///< `local`, or `slurm JOB_TASK`
  std::vector<int> affinity;  ///< processors that it was bound to; empty: none
};

/// Reads `poise.trial/1`. What is no such text counts as pending, and a number out of its range as the nearest within.
Outcome parse_outcome(std::string_view text);

/// The folder of a sweep: the results of trials under their keys, and the logs of those that said something. Results
/// appear complete or not at all, so that other machines that share the folder may write it too.
class TrialStore {
 public:
  explicit TrialStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Makes the folders. Refused as OutputFailed.
  [[nodiscard]] Status make() const;
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] std::filesystem::path result_file(const std::string& key) const;
  [[nodiscard]] std::filesystem::path outcome_file(const std::string& key) const;
  [[nodiscard]] std::filesystem::path log_file(const std::string& key) const;
  /// Where the result of a trial is written until it is complete: a name of its own for each process (`writer`).
  [[nodiscard]] std::filesystem::path work_file(const std::string& key, const std::string& writer) const;

  /// What is stored of a trial. A result without an outcome, or one that cannot be read, counts as pending; so does a
  /// trial that was ended at a lower time limit than it has now.
  [[nodiscard]] Outcome outcome_of(const Trial& trial) const;
  /// Stores the outcome, and moves the result of a trial that is done from `work_file` to its place. Refused as
  /// OutputFailed: what cannot be written; the trial is then pending.
  [[nodiscard]] Status store(const Trial& trial, const Outcome& outcome, const std::filesystem::path& work_file) const;
  /// Removes what killed processes left of unfinished results. Nobody may be at work in the folder.
  void clear_work() const;
  /// Makes a trial pending again. Files that are not there are no error.
  void forget(const std::string& key) const;

 private:
  std::filesystem::path folder_;
};

/// The last lines of a log, at most `most`, each shortened; empty if there is none.
std::vector<std::string> log_tail(const std::filesystem::path& file, std::size_t most);

}  // namespace poise::sweep
