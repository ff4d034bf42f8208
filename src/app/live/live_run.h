// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "app/live/live_message.h"
#include "app/live/live_record.h"
#include "capture/observe.h"
#include "poise/scene/scene.h"
#include "scene/run/run_report.h"

namespace poise::app {

/// A scene that runs while it is changed. Invariant: the World has the settings that were asked for last, and the
/// observer is that of this start of the scene.
///
/// One thread, between frames.
class LiveRun {
 public:
  /// `start`: what `run` was made with.
  LiveRun(const Scene& scene, const SceneRunOptions& start, SceneRun run, Nanoseconds deadline);
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  /// Whether `message` changes the World, and would end a step that goes on, however long that takes.
  [[nodiscard]] bool waits(const LiveMessage& message) const;
  /// Does what is asked. Refused, and nothing changes: what the World refuses, and what cannot be done in this scene.
  Status apply(const LiveMessage& message);

  /// Whether the next frame is to be done. A pause begins when no step is unfinished.
  [[nodiscard]] bool goes_on() const { return !paused_ || steps_ > 0 || run_.world().step_unfinished(); }
  /// Adds and removes the bodies that are due before the next frame, and says how it is to be stepped; the budget is
  /// the caller's.
  Result<StepInput> before_frame();
  SceneRun& scene_run() { return run_; }
  /// After the frame: what it was counts for the status.
  void after_frame(const FrameReport& report);
  /// Fills the lists of a frame, and its facts from `report`; without one those of the start.
  Status observe(const FrameReport* report, capture::SeenFrame& frame);

  [[nodiscard]] LiveStatus status() const;
  [[nodiscard]] Nanoseconds deadline() const { return deadline_; }
  [[nodiscard]] double dt_s() const { return scene_.dt_s; }
  /// Counts starts of the scene.
  [[nodiscard]] std::uint64_t starts() const { return starts_; }
  /// Whether bodies, which a page shows, have changed without a frame: the scene was started again.
  [[nodiscard]] bool begins() const { return frame_ == 0 && !observed_; }

 private:
  Status change_policy(const scheduler::Policy& policy);
  Status start_again();
  Status change_bodies(std::uint64_t wanted);
  Status move_bodies();
  [[nodiscard]] std::uint64_t dynamic_bodies() const;
  [[nodiscard]] View view() const;
  void forget_speed();

  const Scene& scene_;
  SceneRunOptions start_;
  SceneRun run_;
  std::optional<capture::FrameObserver> observer_;
  Nanoseconds deadline_;
  std::optional<View> camera_;  ///< empty: that of the scene
  std::optional<Vec3> gaze_;    ///< empty: that of the camera
  bool paused_ = false;
  bool observed_ = false;
  std::uint64_t steps_ = 0;  ///< to be done while paused, each to its end
  std::uint64_t frame_ = 0;  ///< number of the next
  std::uint64_t starts_ = 1;
  std::uint64_t to_pour_ = 0, to_remove_ = 0;
  std::uint64_t poured_at_once_ = 1;
  std::uint32_t without_room_ = 0;  ///< frames in a row in which none could be poured
  std::deque<MissCause> recent_;
  struct Begun {
    SteadyClock::time_point at;
    bool ended = false;  ///< its step did not go on in the next frame
  };
  std::deque<Begun> begun_;         ///< frames since it was paused last
  std::size_t steps_of_begun_ = 0;  ///< those of them that ended
};

}  // namespace poise::app
