// SPDX-License-Identifier: MIT
#include "app/live/live_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <type_traits>
#include <utility>

namespace poise::app {
namespace {

/// More bodies come within about a second, at most so many before a frame; fewer leave at once. Chosen.
constexpr std::uint64_t kFramesOfPouring = 60;
constexpr std::uint64_t kMostAtOnce = 64;
constexpr std::uint64_t kMostRemoved = 1000;
/// Frames for which bodies wait for room before they are no longer wanted. Chosen.
constexpr std::uint32_t kFramesWithoutRoom = 300;
/// The speed is that of the last so many frames, or of as many as hold so many steps, but of no more than the second
/// number of frames. Chosen.
constexpr std::size_t kFramesOfSpeed = 60, kStepsOfSpeed = 8, kMostOfSpeed = 600;

Status only(const Result<std::uint64_t>& result) { return result ? Status(Done{}) : Status(result.error()); }

}  // namespace

LiveRun::LiveRun(const Scene& scene, const SceneRunOptions& start, SceneRun run, Nanoseconds deadline)
    : scene_(scene), start_(start), run_(std::move(run)), deadline_(deadline) {
  observer_.emplace(scene_, run_, false);
}

Status LiveRun::change_policy(const scheduler::Policy& policy) {
  const Status changed = run_.world().set_policy(policy);
  if (changed) start_.world.policy = policy;
  return changed;
}

Status LiveRun::start_again() {
  Result<SceneRun> again = run_.again(start_);
  if (!again) return again.error();
  again.value().world().set_time_priors(run_.world().time_priors());
  observer_.reset();
  run_ = std::move(again).value();
  observer_.emplace(scene_, run_, false);
  frame_ = 0;
  observed_ = false;
  steps_ = to_pour_ = to_remove_ = 0;
  recent_.clear();
  forget_speed();
  ++starts_;
  return Done{};
}

std::uint64_t LiveRun::dynamic_bodies() const {
  const auto dynamic = [](const RunBody& body) { return body.motion == MotionType::Dynamic; };
  return static_cast<std::uint64_t>(std::ranges::count_if(run_.bodies(), dynamic));
}

Status LiveRun::change_bodies(std::uint64_t wanted) {
  if (wanted > kMostLiveBodies) {
    return bad_input(
        fmt::format("message: count: {} bodies would be there, must be at most {}", wanted, kMostLiveBodies));
  }
  // Refused at once where there is nothing that more bodies could be like.
  const Status possible = only(run_.pour(0));
  if (!possible) return possible;
  const std::uint64_t now = dynamic_bodies();
  to_pour_ = wanted - std::min(wanted, now);
  to_remove_ = now - std::min(wanted, now);
  poured_at_once_ = std::clamp<std::uint64_t>(to_pour_ / kFramesOfPouring, 1, kMostAtOnce);
  without_room_ = 0;
  return Done{};
}

bool LiveRun::waits(const LiveMessage& message) const {
  const bool changes = std::holds_alternative<SetAlpha>(message) || std::holds_alternative<SetWeight>(message) ||
                       std::holds_alternative<SetPolicy>(message) || std::holds_alternative<StartAgain>(message);
  return changes && run_.world().step_unfinished();
}

Status LiveRun::apply(const LiveMessage& message) {
  const auto doing = [this](const auto& asked) -> Status {
    using Asked = std::decay_t<decltype(asked)>;
    if constexpr (std::is_same_v<Asked, SetDeadline>) {
      deadline_ = Nanoseconds(std::max<std::int64_t>(1, static_cast<std::int64_t>(asked.ms * 1e6)));
    } else if constexpr (std::is_same_v<Asked, SetAlpha>) {
      WorldSettings settings = run_.world().settings();
      settings.alpha = asked.value;
      const Status changed = run_.world().set_settings(settings);
      if (changed) start_.world.alpha = asked.value;
      return changed;
    } else if constexpr (std::is_same_v<Asked, SetWeight>) {
      scheduler::Policy policy = run_.world().settings().policy;
      policy.*asked.weight = asked.value;
      return change_policy(policy);
    } else if constexpr (std::is_same_v<Asked, SetPolicy>) {
      scheduler::Policy policy = run_.world().settings().policy;
      policy.kind = asked.kind;
      return change_policy(policy);
    } else if constexpr (std::is_same_v<Asked, SetBodies>) {
      return change_bodies(asked.count);
    } else if constexpr (std::is_same_v<Asked, PourBodies>) {
      return change_bodies(dynamic_bodies() + to_pour_ - to_remove_ + asked.count);
    } else if constexpr (std::is_same_v<Asked, SetView>) {
      if (asked.camera) camera_ = *asked.camera;
      if (asked.gaze) gaze_ = *asked.gaze;
    } else if constexpr (std::is_same_v<Asked, SetPaused>) {
      paused_ = asked.on;
      steps_ = 0;
      forget_speed();
    } else if constexpr (std::is_same_v<Asked, StepFrames>) {
      paused_ = true;
      steps_ = std::min(steps_ + asked.count, kMostSteps);
    } else if constexpr (std::is_same_v<Asked, StartAgain>) {
      return start_again();
    }
    return Done{};
  };
  return std::visit(doing, message);
}

Status LiveRun::move_bodies() {
  if (run_.world().step_unfinished()) return Done{};
  if (to_remove_ > 0) {
    const std::uint64_t at_once = std::min(to_remove_, kMostRemoved);
    to_remove_ -= at_once;
    return only(run_.remove_last(at_once));
  }
  if (to_pour_ == 0) return Done{};
  const Result<std::uint64_t> poured = run_.pour(std::min(to_pour_, poured_at_once_));
  if (!poured) return poured.error();
  to_pour_ -= poured.value();
  without_room_ = poured.value() > 0 ? 0 : without_room_ + 1;
  if (without_room_ == kFramesWithoutRoom) to_pour_ = 0;
  return Done{};
}

View LiveRun::view() const {
  View view = camera_.value_or(run_.view());
  if (gaze_ && view.present) view.gaze = *gaze_;
  return view;
}

Result<StepInput> LiveRun::before_frame() {
  Status done = run_.before_frame(frame_);
  // Of those that were to leave, a stream may have taken some.
  if (to_remove_ > 0) to_remove_ = std::min(to_remove_, dynamic_bodies());
  if (done) done = move_bodies();
  if (!done) return done.error();
  StepInput input;
  input.dt_s = scene_.dt_s;
  input.view = view();
  input.max_level = scene_.max_level;
  input.polygons = scene_.polygons;
  input.backtracking = scene_.backtracking;
  input.may_slice = run_.world().settings().islands_wait == IslandsWait::Any;
  return input;
}

void LiveRun::forget_speed() {
  begun_.clear();
  steps_of_begun_ = 0;
}

void LiveRun::after_frame(const FrameReport& report) {
  ++frame_;
  if (steps_ > 0 && !report.unfinished) --steps_;
  recent_.push_back(report.cause);
  if (recent_.size() > kRecentFrames) recent_.pop_front();
  begun_.push_back({report.started, !report.unfinished});
  steps_of_begun_ += report.unfinished ? 0 : 1;
  while (begun_.size() > kFramesOfSpeed) {
    const std::size_t left = steps_of_begun_ - (begun_.front().ended ? 1 : 0);
    if (left < kStepsOfSpeed && begun_.size() <= kMostOfSpeed) break;
    steps_of_begun_ = left;
    begun_.pop_front();
  }
}

Status LiveRun::observe(const FrameReport* report, capture::SeenFrame& frame) {
  frame.new_bodies.clear();
  frame.bodies.clear();
  frame.contacts.clear();
  frame.facts = report != nullptr ? capture::facts_of(*report, view(), scene_.dt_s) : capture::facts_of_start(view());
  observed_ = true;
  return observer_->observe(frame);
}

LiveStatus LiveRun::status() const {
  LiveStatus status;
  status.deadline_ms = static_cast<double>(deadline_.count()) / 1e6;
  status.alpha = run_.world().settings().alpha;
  status.policy = run_.world().settings().policy;
  status.paused = paused_;
  status.bodies = dynamic_bodies();
  status.bodies_asked = status.bodies + to_pour_ - to_remove_;
  status.frame = frame_;
  for (const MissCause cause : recent_) ++status.recent[static_cast<std::size_t>(cause)];
  if (begun_.size() > 1 && !paused_) {
    // A frame's step counts in the time from its beginning to that of the next frame.
    const std::size_t steps = steps_of_begun_ - (begun_.back().ended ? 1 : 0);
    const double real_s = std::chrono::duration<double>(begun_.back().at - begun_.front().at).count();
    if (real_s > 0) status.speed = static_cast<double>(steps) * scene_.dt_s / real_s;
    if (steps > 0) status.frames_a_step = static_cast<double>(begun_.size() - 1) / static_cast<double>(steps);
  }
  return status;
}

}  // namespace poise::app
