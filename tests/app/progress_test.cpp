// SPDX-License-Identifier: MIT
#include "app/process/progress.h"

#include <gtest/gtest.h>

#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

TEST(Progress, SaysHowMuchIsDoneAndHowLongTheRestTakes) {
  EXPECT_EQ(app::progress_text("frame 5 of 10", 0.5, 4), "50 %, 4 s left: frame 5 of 10");
  EXPECT_EQ(app::progress_text("frame 5 of 10", 0.5, 0.5), "50 %: frame 5 of 10") << "too early to tell";
  EXPECT_EQ(app::progress_text("t", 0.01, 60), "1 %: t") << "too little to tell";
  EXPECT_EQ(app::progress_text("t", 0.25, 100), "25 %, 5 min 0 s left: t");
  EXPECT_EQ(app::progress_text("t", 0.1, 1000), "10 %, 2 h 30 min left: t");
}

TEST(Progress, FitsTheTerminal) {
  EXPECT_EQ(app::fitted_to("frame 5 of 10", 13), "frame 5 of 10");
  EXPECT_EQ(app::fitted_to("frame 5 of 10", 8), "frame 5~");
  EXPECT_EQ(app::fitted_to("frame", 1), "~");
  EXPECT_EQ(app::fitted_to("frame", 0), "");
}

TEST(Progress, IsToldWhereStderrIsNoTerminalUnlessQuiet) {
  // Paced, so that the run takes two seconds on any machine.
  const std::vector<std::string> arguments{"run", "two-body", "--frames", "120", "--paced"};
  const CommandResult told = poise_command(arguments);
  EXPECT_EQ(told.exit_code, 0);
  EXPECT_NE(told.error.find("poise: "), std::string::npos) << told.error;
  EXPECT_NE(told.error.find(" of 120, "), std::string::npos) << told.error;
  std::vector<std::string> quiet = arguments;
  quiet.push_back("--quiet");
  EXPECT_EQ(poise_command(quiet).error, "");
}

}  // namespace
}  // namespace poise::testing
