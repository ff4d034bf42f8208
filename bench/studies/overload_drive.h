// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "parallel/interrupt.h"
#include "studies/driven_scene.h"
#include "studies/overload_figures.h"

namespace poise::app {

/// How the demand on a scene is driven.
struct OverloadSettings {
  bool population = false;  ///< bodies come and go and the limit stays; false: the other way round
  bool wall_clock = true;   ///< the limit is a deadline; false: work units
  std::uint64_t bodies = 0;
  std::uint64_t settle = 0;  ///< frames without a limit before the demand is driven, >= 1
  std::uint64_t hold = 0;    ///< frames a step, >= 2
  Shake shake;
  std::optional<std::uint64_t> reference_every;  ///< >= 1
  std::vector<simulation::OverloadStep> steps;
};

/// Time or work of a frame without a limit: demand 1 is a limit of this, at the population that it was measured with.
struct OverloadUnit {
  double frame_ms = 0;    ///< median
  double work_units = 0;  ///< mean
};

/// Limit of a frame at a demand for time or work, rounded to whole nanoseconds or units, at least one.
FrameLimit limit_of(const OverloadUnit& unit, double demand, bool wall_clock);

/// A scene that was driven under the limit, and again without: as many frames each, `hold` a step.
struct OverloadDrive {
  OverloadUnit unit;
  std::vector<simulation::RunFrame> frames, unlimited;
};

/// Told after each frame how much of the whole is done, in [0, 1].
using ShareSink = std::function<void(double share)>;

/// Settles a scene without a limit and drives its demand through the steps; before that, drives one without a limit in
/// the same way, in whose last frames of settling the unit is measured. Refused: as DrivenScene, a scene that has
/// nothing to refine on the work clock, and after Ctrl-C.
Result<OverloadDrive> drive_overload(const Scene& scene, const SceneRunOptions& options,
                                     const OverloadSettings& settings, const ShareSink& told,
                                     const parallel::Interrupt* interrupt = nullptr);

}  // namespace poise::app
