// SPDX-License-Identifier: MIT
#include "app/live/live_loop.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "scene/run/release_grid.h"

namespace poise::app {
namespace {

/// How often a paused run looks for requests, and a sleep for its end. Chosen.
constexpr Nanoseconds kLooking = std::chrono::milliseconds(15);

void sleep_until(SteadyClock::time_point when) {
  const auto since = std::chrono::duration_cast<Nanoseconds>(when.time_since_epoch()).count();
  constexpr std::int64_t kSecond = 1'000'000'000;
  const timespec target{static_cast<time_t>(since / kSecond), static_cast<long>(since % kSecond)};
  // Woken by a signal it sleeps less.
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &target, nullptr);
}

/// Drives the frames. Invariant: `grid_` is that of the run's deadline, and begins anew after a pause.
class Loop {
 public:
  Loop(LiveRun& run, LiveLink& link, const LiveLoopSettings& settings)
      : run_(run), link_(link), settings_(settings), grid_(SteadyClock::now(), run.dt_s(), run.deadline()) {}

  Result<std::uint64_t> go() {
    Status done = tell(nullptr);
    while (done && !settings_.stops() && (!settings_.frames || steps_ < *settings_.frames)) {
      done = take_requests();
      if (done && !run_.goes_on()) {
        done = wait();
      } else if (done) {
        done = frame();
      }
    }
    if (!done) return done.error();
    return steps_;
  }

 private:
  void begin_grid() { grid_ = simulation::ReleaseGrid(SteadyClock::now(), run_.dt_s(), run_.deadline()); }

  Status take_requests() {
    while (waiting_ || link_.requests.take(request_)) {
      // What changes the World waits until no step is unfinished, and what was asked for later with it.
      waiting_ = run_.waits(request_.message);
      if (waiting_) break;
      const Nanoseconds deadline = run_.deadline();
      const bool waited = !run_.goes_on();
      const Status applied = run_.apply(request_.message);
      if (!applied) replies_.push_back({request_.client, applied.error().message});
      if (deadline != run_.deadline() || (waited && run_.goes_on())) begin_grid();
    }
    if (!run_.begins()) return Done{};
    begin_grid();
    return tell(nullptr);
  }

  Status wait() {
    put(false);
    sleep_until(SteadyClock::now() + kLooking);
    return Done{};
  }

  /// False if it is to end.
  bool wait_for_release() {
    while (SteadyClock::now() < grid_.release()) {
      if (settings_.stops()) return false;
      sleep_until(std::min(grid_.release(), SteadyClock::now() + kLooking));
    }
    return true;
  }

  Status frame() {
    Result<StepInput> input = run_.before_frame();
    if (!input) return input.error();
    const bool waited = SteadyClock::now() < grid_.release();
    if (settings_.paced && !wait_for_release()) return Done{};
    if (settings_.paced) {
      input.value().budget = Budget::until(grid_.deadline());
      input.value().release = grid_.release();
    } else {
      input.value().budget = Budget::within(run_.deadline());
    }
    FrameReport report = run_.scene_run().world().step(input.value());
    if (report.status != StepStatus::Done) return bad_input("the step was refused: its input is out of range");
    if (report.cause == MissCause::Release) report.cause = simulation::cause_of_release(before_, waited);
    before_ = report.cause;
    ++steps_;
    const SteadyClock::time_point ended = SteadyClock::now();
    run_.after_frame(report);
    const Status told = tell(&report);
    // As with a capture, the time that this takes belongs to no frame.
    grid_.postpone(SteadyClock::now() - ended);
    grid_.advance(SteadyClock::now());
    return told;
  }

  /// Hands over a frame, or the start of the scene.
  Status tell(const FrameReport* report) {
    if (!link_.records.has_room()) {
      ++left_out_;
      ++left_out_now_;
      return Done{};
    }
    const Status seen = run_.observe(report, record_.frame);
    if (!seen) return seen;
    record_.frame.facts.left_out = std::exchange(left_out_now_, 0);
    put(true);
    return Done{};
  }

  void put(bool has_frame) {
    if (!link_.records.has_room()) return;
    record_.run = run_.starts();
    record_.has_frame = has_frame;
    record_.status = run_.status();
    record_.status.left_out = left_out_;
    record_.replies.swap(replies_);
    replies_.clear();
    [[maybe_unused]] const bool given = link_.records.give(record_);
    settings_.told();
  }

  LiveRun& run_;
  LiveLink& link_;
  const LiveLoopSettings& settings_;
  simulation::ReleaseGrid grid_;
  LiveRequest request_;
  bool waiting_ = false;  ///< request_ is still to be done
  LiveRecord record_;
  std::vector<LiveReply> replies_;
  MissCause before_ = MissCause::None;
  std::uint64_t steps_ = 0, left_out_ = 0;
  std::uint32_t left_out_now_ = 0;
};

}  // namespace

Result<std::uint64_t> live_loop(LiveRun& run, LiveLink& link, const LiveLoopSettings& settings) {
  return Loop(run, link, settings).go();
}

}  // namespace poise::app
