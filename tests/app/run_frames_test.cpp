// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "app/command.h"
#include "app/run/run_loop.h"
#include "parallel/interrupt.h"
#include "scene/run/reference_turns.h"
#include "scene/run/run_report.h"

namespace poise::app {
namespace {

TEST(RunFrames, OfMoreThanTheMemoryHasRoomForAreRefusedBeforeTheFirst) {
  const testing::CommandResult refused =
      testing::poise_command({"run", "two-body", "--frames", "900000", "--warmup", "100000", "--max-memory", "100"});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_NE(refused.error.find("poise run: 1000000 frames: their figures take"), std::string::npos) << refused.error;
  EXPECT_NE(refused.error.find("and --max-memory, or what the machine has, is 100 MiB"), std::string::npos);
  LoopSettings loop;
  loop.frames = 1000;
  EXPECT_TRUE(check_memory_of_frames(loop, 1000 * sizeof(simulation::RunFrame)));
  EXPECT_FALSE(check_memory_of_frames(loop, 1000 * sizeof(simulation::RunFrame) - 1));
  EXPECT_TRUE(check_memory_of_frames(loop, std::nullopt));
}

std::vector<bool> turns(std::optional<std::uint64_t> every, const std::vector<bool>& begins) {
  simulation::ReferenceTurns references(every);
  std::vector<bool> due;
  for (std::size_t i = 0; i < begins.size(); ++i) due.push_back(references.due(i + 1, begins[i]));
  return due;
}

TEST(ReferenceTurns, PassFromAFrameThatGoesOnWithAStepToTheNextThatBeginsOne) {
  EXPECT_EQ(turns(2, {true, true, true, true, true}), (std::vector<bool>{false, true, false, true, false}));
  EXPECT_EQ(turns(3, {true, true, false, false, true, true, true}),
            (std::vector<bool>{false, false, false, false, true, true, false}))
      << "that of frame 3 is had by frame 5, and frame 6 has its own";
  EXPECT_EQ(turns(1, {false, false, true}), (std::vector<bool>{false, false, true}));
  EXPECT_EQ(turns(std::nullopt, {true, true}), (std::vector<bool>{false, false}));
}

// Jacks that fall into a tray, each frame over before it begins.
LoopResult hopeless_run(std::uint64_t frames, std::optional<std::uint64_t> reference_every) {
  const Scene scene = read_scene(POISE_SOURCE_DIR "/scenes/jacks.json").value();
  SceneRunOptions options;
  options.bodies = 300;
  options.world.threads = 2;
  SceneRun run = SceneRun::create(scene, options).value();
  LoopSettings loop;
  loop.frames = frames;
  loop.dt_s = scene.dt_s;
  loop.deadline = Nanoseconds(1);
  loop.reference_every = reference_every;
  const parallel::Interrupt interrupt;
  return run_loop(run, loop, interrupt, {}, {}).value();
}

TEST(RunFrames, ThoseWithAReferenceAloneAreNotDoneInSlices) {
  const LoopResult result = hopeless_run(60, 20);
  std::uint64_t unfinished = 0;
  std::uint64_t references = 0;
  bool begins = true;
  for (const simulation::RunFrame& frame : result.frames) {
    if (frame.report.reference) {
      ++references;
      EXPECT_TRUE(begins) << frame.report.frame;
      EXPECT_FALSE(frame.report.unfinished) << frame.report.frame;
    }
    begins = !frame.report.unfinished;
    unfinished += frame.report.unfinished ? 1 : 0;
  }
  EXPECT_GT(unfinished, 0U) << "steps take several frames between them";
  EXPECT_GE(references, 2U);
  for (const simulation::RunFrame& frame : hopeless_run(10, 1).frames) {
    EXPECT_TRUE(frame.report.reference);
    EXPECT_FALSE(frame.report.unfinished);
  }
}

TEST(RunFrames, OfTheWarmUpAreNotInTheLargestEnergy) {
  // A ball comes in the first frame and flies at a floor, where it stays.
  const Scene scene = parse_scene(R"({"name": "s", "dt_s": 0.01, "gravity_mps2": [0, 0, -10], "materials": {"m": {}},
    "shapes": {"ball": {"sphere": {"radius_m": 0.5}}, "ground": {"plane": {"normal": [0, 0, 1]}}},
    "bodies": [{"shape": "ground", "material": "m", "motion": "static"}],
    "generators": [{"stream": {"shape": "ball", "material": "m", "per_second": 100, "total": 1,
      "region_min_m": [0, 0, 1], "region_max_m": [0, 0, 1], "velocity_mps": [0, 0, -10]}}]})",
                                  "s.json", ".")
                          .value();
  SceneRunOptions options;
  options.world.threads = 1;
  SceneRun run = SceneRun::create(scene, options).value();
  LoopSettings loop;
  loop.warm_up = 100;
  loop.frames = 50;
  loop.dt_s = scene.dt_s;
  loop.wall_clock = false;
  const parallel::Interrupt interrupt;
  const LoopResult result = run_loop(run, loop, interrupt, {}, {}).value();
  double warm_up_j = 0;
  double measured_j = result.start.kinetic_j + result.start.potential_j;
  for (const simulation::RunFrame& frame : result.frames) {
    const double now_j = frame.report.kinetic_j + frame.report.potential_j;
    (frame.warm_up ? warm_up_j : measured_j) = std::max(frame.warm_up ? warm_up_j : measured_j, now_j);
  }
  EXPECT_GT(warm_up_j, 5 * measured_j);
  EXPECT_EQ(result.energy_max_j, measured_j);
}

}  // namespace
}  // namespace poise::app
