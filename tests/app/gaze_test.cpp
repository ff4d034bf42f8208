// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

json done(Words arguments) {
  arguments.insert(arguments.end(), {"--json", "-", "--quiet"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return json::parse(result.out, nullptr, false);
}

Words run_of(const Words& more) {
  Words arguments{"run", "jacks", "--bodies", "80", "--frames", "60", "--clock", "work", "--budget-work", "20"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(GazeOption, DecidesWhatIsRefinedAndIsReplayedWithoutItsFile) {
  const TemporaryFolder folder;
  const std::string file = folder.file("gaze.csv");
  std::ofstream(file) << "time_s,x_px,y_px\n0,0,0\n0.5,1280,720\n";
  const json plain = done(run_of({}));
  const json gazed = done(run_of({"--gaze", file, "--record", folder.file("run.poise")}));
  EXPECT_NE(gazed.at("state_hash"), plain.at("state_hash"));
  std::filesystem::remove(file);
  const json replay = done({"replay", folder.file("run.poise"), "--explain", "50"});
  EXPECT_EQ(replay.at("same"), true);
  // What is explained has the eccentricity from the recorded gaze: the lower right corner is far from the heap.
  double nearest_rad = 10;
  for (const char* list : {"refined", "left_coarse"}) {
    for (const json& row : replay.at("explain").at(list))
      nearest_rad = std::min(nearest_rad, row.at("cues").at("eccentricity_rad").get<double>());
  }
  EXPECT_GT(nearest_rad, 0.2);
}

TEST(GazeOption, IsRefusedWithFileLineFieldValueAndRule) {
  const TemporaryFolder folder;
  const std::string file = folder.file("gaze.csv");
  std::ofstream(file) << "0,10,10\n1,2000,10\n";
  const CommandResult bad = poise_command(run_of({"--gaze", file}));
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_NE(bad.error.find("gaze.csv: line 2: x_px = 2000, must be 0 to 1280"), std::string::npos) << bad.error;
  const CommandResult none = poise_command(run_of({"--gaze", folder.file("none.csv")}));
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_NE(none.error.find("none.csv: cannot be read: no such file"), std::string::npos) << none.error;
  std::string scene = contents(POISE_SOURCE_DIR "/scenes/two-body.json");
  scene.insert(scene.find("\"camera\""), "\"gaze\": {\"file\": \"gaze.csv\"}, ");
  std::ofstream(folder.file("gazing.json")) << scene;
  for (const char* command : {"run", "check"}) {
    const CommandResult gazing = poise_command({command, folder.file("gazing.json")});
    EXPECT_EQ(gazing.exit_code, 3);
    EXPECT_NE(gazing.error.find("gazing.json: gaze.file: " + file + ": line 2: x_px = 2000, must be 0 to 1280"),
              std::string::npos)
        << gazing.error;
  }
  std::ofstream(folder.file("blind.json"))
      << R"({"name": "blind", "dt_s": 0.01, "materials": {"m": {}}, "shapes": {"s": {"sphere": {"radius_m": 1}}},
             "bodies": [{"shape": "s", "material": "m"}]})";
  const CommandResult blind = poise_command({"run", folder.file("blind.json"), "--gaze", file});
  EXPECT_EQ(blind.exit_code, 2);
  EXPECT_NE(blind.error.find("--gaze: the scene blind has no camera"), std::string::npos) << blind.error;
}

}  // namespace
}  // namespace poise::testing
