// SPDX-License-Identifier: MIT
#include "studies/overload_drive.h"

#include <algorithm>
#include <cmath>

#include "app/process/refusal.h"
#include "scene/run/milliseconds.h"
#include "scene/run/reference_turns.h"

namespace poise::app {
namespace {

// Last frames of settling in which the unit is measured. Chosen.
constexpr std::uint64_t kUnitFrames = 60;

std::uint64_t population_at(const OverloadSettings& settings, double demand) {
  if (!settings.population) return settings.bodies;
  return std::max<std::uint64_t>(
      1, static_cast<std::uint64_t>(std::llround(demand * static_cast<double>(settings.bodies))));
}

OverloadUnit unit_of(std::span<const simulation::RunFrame> frames) {
  const std::span<const simulation::RunFrame> last = frames.last(std::min<std::size_t>(frames.size(), kUnitFrames));
  OverloadUnit unit;
  std::vector<double> times_ms;
  for (const simulation::RunFrame& frame : last) {
    times_ms.push_back(ms(frame.report.times.total));
    unit.work_units += static_cast<double>(frame.report.work_refine) / static_cast<double>(last.size());
  }
  unit.frame_ms = simulation::percentile(times_ms, 0.5);
  return unit;
}

/// One scene, driven from its start; counts its frames for the progress.
class Drive {
 public:
  Drive(const Scene& scene, const SceneRunOptions& options, const OverloadSettings& settings,
        const parallel::Interrupt* interrupt, const std::function<void()>& told)
      : scene_(scene), options_(options), settings_(settings), interrupt_(interrupt), told_(told) {}

  /// Lets `bodies` come to rest.
  Result<std::vector<simulation::RunFrame>> settle(std::uint64_t bodies) {
    std::uint64_t most = bodies;
    for (const simulation::OverloadStep& step : settings_.steps)
      most = std::max(most, population_at(settings_, step.demand));
    Result<DrivenScene> made = DrivenScene::create(scene_, options_, most, bodies, settings_.shake);
    if (!made) return made.error();
    driven_.emplace(std::move(made).value());
    std::vector<simulation::RunFrame> frames;
    for (std::uint64_t i = 0; i < settings_.settle; ++i) {
      const Status done = step({}, false, frames);
      if (!done) return done.error();
    }
    return frames;
  }

  /// All steps, under the limit or without.
  Result<std::vector<simulation::RunFrame>> steps(const std::optional<OverloadUnit>& unit) {
    std::vector<simulation::RunFrame> frames;
    simulation::ReferenceTurns references(unit ? settings_.reference_every : std::nullopt);
    for (const simulation::OverloadStep& held : settings_.steps) {
      const std::uint64_t from = driven_->population();
      FrameLimit limit =
          unit ? limit_of(*unit, settings_.population ? 1 : held.demand, settings_.wall_clock) : FrameLimit{};
      for (std::uint64_t i = 0; i < settings_.hold; ++i) {
        Status done = change_population(from, population_at(settings_, held.demand), i);
        const bool reference = references.due(frames.size() + 1, !driven_->world().step_unfinished());
        limit.may_slice = !reference;
        if (done) done = step(limit, reference, frames);
        if (!done) return done.error();
      }
    }
    return frames;
  }

 private:
  /// In equal parts over the first half of a step.
  Status change_population(std::uint64_t from, std::uint64_t to, std::uint64_t frame) {
    if (!settings_.population) return Done{};
    const double share = std::min(1.0, static_cast<double>(frame + 1) / (0.5 * static_cast<double>(settings_.hold)));
    const double bodies = std::lerp(static_cast<double>(from), static_cast<double>(to), share);
    return driven_->set_population(static_cast<std::uint64_t>(std::llround(bodies)));
  }
  Status step(const FrameLimit& limit, bool reference, std::vector<simulation::RunFrame>& frames) {
    if (interrupt_ != nullptr && interrupt_->asked()) return stopped_error();
    Result<simulation::RunFrame> frame = driven_->step(limit, reference);
    if (!frame) return frame.error();
    frames.push_back(std::move(frame).value());
    told_();
    return Done{};
  }

  const Scene& scene_;
  const SceneRunOptions& options_;
  const OverloadSettings& settings_;
  const parallel::Interrupt* interrupt_;
  const std::function<void()>& told_;
  std::optional<DrivenScene> driven_;
};

}  // namespace

FrameLimit limit_of(const OverloadUnit& unit, double demand, bool wall_clock) {
  FrameLimit limit;
  if (wall_clock) {
    limit.deadline = Nanoseconds(std::max<std::int64_t>(1, std::llround(1e6 * unit.frame_ms / demand)));
  } else {
    limit.work_units = static_cast<std::uint64_t>(std::max<std::int64_t>(1, std::llround(unit.work_units / demand)));
  }
  return limit;
}

Result<OverloadDrive> drive_overload(const Scene& scene, const SceneRunOptions& options,
                                     const OverloadSettings& settings, const ShareSink& told,
                                     const parallel::Interrupt* interrupt) {
  // Where the population is driven, the unit is that of the one that fits, in a tray for the largest: a third run.
  const std::uint64_t runs = settings.population ? 3 : 2;
  const std::uint64_t total = runs * settings.settle + 2 * settings.steps.size() * settings.hold;
  std::uint64_t done = 0;
  const std::function<void()> count = [&] { told(static_cast<double>(++done) / static_cast<double>(total)); };
  OverloadDrive result;
  if (settings.population) {
    Drive fitting(scene, options, settings, interrupt, count);
    const Result<std::vector<simulation::RunFrame>> settled = fitting.settle(settings.bodies);
    if (!settled) return settled.error();
    result.unit = unit_of(settled.value());
  }
  const std::uint64_t start = population_at(settings, settings.steps.front().demand);
  for (const bool limited : {false, true}) {
    Drive drive(scene, options, settings, interrupt, count);
    const Result<std::vector<simulation::RunFrame>> settled = drive.settle(start);
    if (!settled) return settled.error();
    if (!limited && !settings.population) result.unit = unit_of(settled.value());
    if (!settings.wall_clock && result.unit.work_units <= 0)
      return bad_input(scene.source + ": has nothing to refine once it has settled, so its demand for work is 0");
    Result<std::vector<simulation::RunFrame>> driven = drive.steps(limited ? std::optional(result.unit) : std::nullopt);
    if (!driven) return driven.error();
    (limited ? result.frames : result.unlimited) = std::move(driven).value();
  }
  return result;
}

}  // namespace poise::app
