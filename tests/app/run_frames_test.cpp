// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "app/command.h"
#include "app/run/run_loop.h"
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

}  // namespace
}  // namespace poise::app
