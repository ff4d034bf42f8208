// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "parallel/executor.h"
#include "solver/solver.h"

namespace poise::solver {

/// Ends the iterations of the substeps of a step where there is no time for more, or where they ended so in another
/// run (SolveSettings::until, repeated). Reads the executor's clock once an iteration, and only if it has to end in
/// time. The calling thread.
class IterationStop {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// Before the first substep: each has an equal share of the time that is left.
  void begin(const SolveSettings& settings, const parallel::Executor& executor) {
    settings_ = &settings;
    executor_ = &executor;
    outcome_.stopped_after.assign(static_cast<std::size_t>(settings.substeps), 0);
    outcome_.beyond = {};
    substep_ = 0;
    if (settings.until) begun_ = outcome_.ended = executor.time();
  }
  void begin_substep() {
    first_ended_.reset();
    if (!settings_->until) return;
    before_ = executor_->time();
    until_ = begun_ + (*settings_->until - begun_) / settings_->substeps * static_cast<int>(substep_ + 1);
  }
  /// After an iteration, the first of which is 0, where another one would be made: is there no time for it? It is
  /// expected to take as long as this one.
  [[nodiscard]] bool stops(std::uint32_t iteration) {
    const auto& repeated = settings_->repeated;
    bool stop = substep_ < repeated.size() && repeated[substep_] == iteration + 1;
    if (settings_->until) {
      const TimePoint now = executor_->time();
      if (!first_ended_) first_ended_ = now;
      stop = stop || now + (now - before_) > until_;
      before_ = now;
    }
    if (stop) outcome_.stopped_after[substep_] = iteration + 1;
    return stop;
  }
  void end_substep() {
    ++substep_;
    if (!settings_->until) return;
    outcome_.ended = executor_->time();
    if (first_ended_) outcome_.beyond += outcome_.ended - *first_ended_;
  }
  [[nodiscard]] const IterationsMade& outcome() const { return outcome_; }

 private:
  const SolveSettings* settings_ = nullptr;
  const parallel::Executor* executor_ = nullptr;
  std::size_t substep_ = 0;
  TimePoint begun_{}, before_{}, until_{};
  std::optional<TimePoint> first_ended_;  // of this substep, if another was to follow
  IterationsMade outcome_;
};

}  // namespace poise::solver
