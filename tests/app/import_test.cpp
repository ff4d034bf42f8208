// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

const std::string kTable = POISE_SOURCE_DIR "/scenes/robots/table.xml";
const std::string kShelfFile = POISE_SOURCE_DIR "/scenes/robots/shelf.gltf";

/// Runs a scene without a clock and returns its JSON.
json run_of(const std::string& scene, const std::string& frames, const std::string& states) {
  const CommandResult run = poise_command({"run", scene, "--frames", frames, "--clock", "work", "--threads", "1",
                                           "--max-level", "polygons", "--json", "-", "--states", states});
  EXPECT_EQ(run.exit_code, 0) << run.error;
  return json::parse(run.out, nullptr, false);
}

/// The height of each body in the last rows of a table of states.
std::vector<double> last_heights(const std::string& states, std::size_t bodies) {
  const std::vector<std::string> rows = lines(contents(states));
  const std::vector<std::string> head = cells(rows.at(0));
  const auto column = static_cast<std::size_t>(std::find(head.begin(), head.end(), "z_m") - head.begin());
  std::vector<double> heights;
  for (std::size_t i = rows.size() - bodies; i < rows.size(); ++i)
    heights.push_back(std::stod(cells(rows[i]).at(column)));
  return heights;
}

// The examples of docs/my-robots.md.
TEST(ImportCommand, MakesASceneOfAModelOfMuJoCoThatRuns) {
  const TemporaryFolder folder;
  const std::string scene = folder.file("table.json");
  const CommandResult made = poise_command({"import", kTable, "-o", scene, "--depth", "2"});
  ASSERT_EQ(made.exit_code, 0) << made.error;
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.out, scene + ": 10 bodies, 4 of them dynamic, 7 shapes, 4 mesh files\n");
  EXPECT_EQ(poise_command({"check", scene}).exit_code, 0);
  const json run = run_of(scene, "150", folder.file("states.csv"));
  EXPECT_EQ(run.at("bodies"), 10);
  const std::vector<double> heights = last_heights(folder.file("states.csv"), 10);
  // The pill of half 0.03 m lies flat on the table top, whose surface is at 0.74 m.
  EXPECT_NEAR(heights.at(9), 0.77, 0.005);
  for (std::size_t i = 6; i < 10; ++i) {
    EXPECT_GT(heights[i], 0) << i << " fell through the floor";
    EXPECT_LT(heights[i], 1) << i << " did not fall";
  }
}

TEST(ImportCommand, MakesASceneOfGltfNodesThatRuns) {
  const TemporaryFolder folder;
  const std::string scene = folder.file("shelf.json");
  const CommandResult made =
      poise_command({"import", kShelfFile, "-o", scene, "--static", "plank", "--floor", "--depth", "2"});
  ASSERT_EQ(made.exit_code, 0) << made.error;
  EXPECT_EQ(made.out, scene + ": 3 bodies, 1 of them dynamic, 3 shapes, 2 mesh files\n");
  EXPECT_EQ(run_of(scene, "120", folder.file("states.csv")).at("bodies"), 3);
  // A cube of 0.4 m on a plank whose upper side is at 1.05 m.
  EXPECT_NEAR(last_heights(folder.file("states.csv"), 3).at(0), 1.25, 0.005);
}

TEST(ImportCommand, ASceneBeyondTheLimitsOfScenesReplacesNothing) {
  const TemporaryFolder folder;
  const std::string model = folder.file("far.xml");
  std::ofstream(model)
      << R"(<mujoco><worldbody><body pos="1e300 0 0"><freejoint/><geom type="sphere" size="0.1"/></body>
</worldbody></mujoco>)";
  const std::string scene = folder.file("far.json");
  std::ofstream(scene) << "mine";
  const CommandResult refused = poise_command({"import", model, "-o", scene});
  EXPECT_EQ(refused.exit_code, 3) << refused.error;
  EXPECT_EQ(contents(scene), "mine");
}

TEST(ImportCommand, RefusesOrLeavesOutWhatIsNotModelled) {
  const TemporaryFolder folder;
  const std::string model = folder.file("arm.xml");
  std::ofstream(model) << "<mujoco><worldbody><body><joint/>\n<geom size='1'/></body></worldbody></mujoco>";
  const std::string scene = folder.file("arm.json");
  const CommandResult refused = poise_command({"import", model, "-o", scene});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_EQ(refused.error,
            "poise import: " + model + ": not modelled: hinge joint (at line 1); --skip-unmodelled leaves this out\n");
  EXPECT_EQ(folder.entries(), 1U) << "nothing is written";
  const CommandResult skipped = poise_command({"import", model, "-o", scene, "--skip-unmodelled"});
  EXPECT_EQ(skipped.exit_code, 0);
  EXPECT_EQ(skipped.error, "poise import: warning: " + model + ": not modelled: hinge joint (at line 1)\n");
  std::ofstream(model) << "<mujoco><asset><mesh file='no.obj'/></asset><worldbody><geom type='mesh' mesh='no'/>"
                          "</worldbody></mujoco>";
  const CommandResult missing = poise_command({"import", model, "-o", scene});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_EQ(missing.error,
            "poise import: " + model + ": mesh 'no': " + folder.file("no.obj") + ": cannot be read: no such file\n");
}

TEST(ImportCommand, RefusesWhatHasNoMeaning) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"a.obj", "-o", "a.json"}, "a.obj: the ending must be .xml or .mjcf (MuJoCo), .gltf or .glb"},
      {{"a.urdf", "-o", "a.json"}, ".gltf or .glb; `poise tree` reads robots"},
      {{"a.xml", "-o", "a.txt"}, "-o a.txt: the ending must be .json"},
      {{"a.xml", "-o", "a.json", "--floor"}, "--floor has no meaning but with glTF"},
      {{"a.xml", "-o", "a.json", "--static", "b"}, "--static has no meaning but with glTF"},
      {{"a.xml", "-o", "a.json", "--scale", "2"}, "--scale has no meaning but with glTF"},
      {{"a.gltf", "-o", "a.json", "--scale", "0"}, "--scale = 0, must be"},
      {{"a.glb", "-o", "a.json", "--skip-unmodelled"}, "--skip-unmodelled has no meaning with glTF"},
      {{"a.xml", "-o", "a.json", "--dt", "0"}, "--dt = 0, must be a number > 0"},
  };
  for (auto [arguments, message] : cases) {
    arguments.insert(arguments.begin(), "import");
    const CommandResult result = poise_command(arguments);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  }
}

}  // namespace
}  // namespace poise::testing
