// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "frame/recorded_run.h"
#include "verify/world_access.h"

namespace poise {
namespace {

TEST(Decisions, IterationsThatTheClockStoppedAreStoppedAgain) {
  const Case c{.name = "stopped"};
  Stage stage(settings_of(c, ExecutorKind::Threads, 3), 0.2);
  fill(c, stage);
  StepInput input = input_of(c);
  input.record = true;
  input.budget = Budget::within(std::chrono::minutes(15));
  Recorded recorded;
  std::size_t first_stopped = 0;
  std::size_t stopped = 0;
  for (std::size_t i = 0; i < 90; ++i) {
    // From here on all of the time is kept for what comes after the iterations.
    scheduler::TailForecast::Features rest_us{};
    rest_us[0] = i < 50 ? 0 : 1e9;
    simulation::WorldAccess::of(stage.world).forecasts.rest = scheduler::TailForecast(rest_us);
    const FrameReport report = stage.world.step(input);
    recorded.decisions.emplace_back();
    stage.world.decisions(recorded.decisions.back());
    recorded.hashes.push_back(stage.world.state_hash());
    const std::vector<std::uint32_t>& after = recorded.decisions.back().stopped_after;
    if (after.empty()) continue;
    EXPECT_GE(i, 50U);
    EXPECT_EQ(after.size(), 2U) << "one a substep";
    EXPECT_LE(*std::max_element(after.begin(), after.end()), 1U) << "after the first there was no time";
    EXPECT_GT(report.degraded.point_iterations, 0U);
    if (stopped++ == 0) first_stopped = i;
  }
  EXPECT_GT(stopped, 30U);
  EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Serial, 1), recorded.hashes.size());
  EXPECT_EQ(frames_alike(c, recorded, ExecutorKind::Tbb, 2), recorded.hashes.size());
  Recorded whole = recorded;
  whole.decisions[first_stopped].stopped_after.clear();
  EXPECT_EQ(frames_alike(c, whole, ExecutorKind::Serial, 1), first_stopped);
}

}  // namespace
}  // namespace poise
