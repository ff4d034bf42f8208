// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

struct Case {
  std::vector<std::string> arguments;
  std::string message;  ///< a part of the error message
};

void expect_refusals(int exit_code, const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    std::string line;
    for (const std::string& word : c.arguments) line += word + " ";
    const CommandResult result = poise_command(c.arguments);
    EXPECT_EQ(result.exit_code, exit_code) << line << "\n" << result.error;
    EXPECT_NE(result.error.find(c.message), std::string::npos) << line << "\n" << result.error;
    EXPECT_EQ(result.out, "") << line;
  }
}

Case run(const std::vector<std::string>& options, const std::string& message) {
  std::vector<std::string> arguments{"run", "two-body", "--frames", "2"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  return {arguments, message};
}

TEST(Refusals, OfBadUsageEndWithTwo) {
  expect_refusals(
      2,
      {
          {{}, "a command is required"},
          {{"fly"}, "not expected: fly"},
          {{"chek", "two-body"}, "poise: did you mean check instead of chek?"},
          run({"--frmaes=3"}, "poise run: did you mean --frames instead of --frmaes=3?"),
          run({"--clock", "work", "--buget-work", "5"}, "did you mean --budget-work instead of --buget-work?"),
          {{"tree", "--preset", "fats"}, "--preset: \"fats\" must be fast, default or best; did you mean \"fast\"?"},
          {{"run"}, "scene is required"},
          {{"run", "two-body", "--frames", "0"}, "--frames = 0, must be a whole number from 1 to 1000000"},
          {{"run", "two-body", "--frames", "-1"}, "--frames = -1, must be a whole number from 1 to 1000000"},
          {{"run", "two-body", "--frames", "2.5"}, "--frames = 2.5, must be"},
          {{"run", "two-body", "--frames", "99999999999999999999"}, "--frames = 99999999999999999999, must be"},
          {{"run", "two-body", "--frames", "many"}, "--frames = many, must be"},
          {{"run", "two-body", "--frames"}, "--frames"},
          run({"--deadline", "0"}, "--deadline = 0, must be a number > 0"),
          run({"--deadline", "-3"}, "--deadline = -3, must be a number > 0"),
          run({"--deadline", "nan"}, "--deadline = nan, must be a number > 0"),
          run({"--deadline", "inf"}, "--deadline = inf, must be a number > 0"),
          run({"--deadline", "1e400"}, "--deadline = 1e400, must be a number > 0"),
          run({"--host-work", "-1"}, "--host-work = -1, must be a number >= 0"),
          run({"--threads", "257"}, "--threads = 257, must be a whole number from 0 to 256"),
          run({"--bodies", "0"}, "--bodies = 0, must be a whole number from 1"),
          run({"--bodies", "5"}, "--bodies: the scene two-body has no generators"),
          run({"--seed", "-1"}, "--seed = -1, must be"),
          run({"--max-level", "7"}, "--max-level = 7, must be a whole number from 0 to 6, or polygons"),
          run({"--max-level", "polygon"}, "--max-level = polygon, must be a whole number from 0 to 6, or polygons"),
          run({"--reference", "every=0"},
              "--reference = every=0, must be every=K with a whole number K from 1 to 1000000"),
          run({"--reference", "5"}, "--reference = 5, must be every=K"),
          run({"--reference", "every=2.5"}, "--reference = every=2.5, must be every=K"),
          run({"--reference", "every=-1"}, "--reference = every=-1, must be every=K"),
          run({"--reference", "every="}, "--reference = every=, must be every=K"),
          run({"--reference", "each=3"}, "--reference = each=3, must be every=K"),
          run({"--reference"}, "--reference"),
          run({"--policy", "best"},
              "--policy: \"best\" must be perceptual, fifo, random, round-robin, size, deepest or equal-levels"),
          run({"--policy", "radnom"},
              "must be perceptual, fifo, random, round-robin, size, deepest or equal-levels; did you mean \"random\"?"),
          run({"--weight", "closing"}, "--weight: \"closing\", must be CUE=VALUE with a CUE of frustum"),
          run({"--weight", "closing=11"}, "--weight: closing = 11, must be from 0 to 10"),
          run({"--contact", "magic"}, "--contact"),
          run({"--clock", "sun"}, "--clock"),
          run({"--executor", "magic"}, "--executor"),
          run({"--zebra"}, "--zebra"),
          run({"another-scene"}, "another-scene"),
          run({"--budget-work", "5"}, "--budget-work needs --clock work"),
          run({"--clock", "work", "--deadline", "5"}, "--deadline has no meaning with --clock work"),
          run({"--clock", "work", "--paced"}, "--paced has no meaning with --clock work"),
          run({"--clock", "work", "--host-work", "1"}, "--host-work has no meaning with --clock work"),
          run({"--states", "-"}, "only --json can go to the standard output"),
          run({"--json", "a", "--states", "./a"}, "named for two outputs"),
          run({"--picture", "a.jpg"}, "the ending must be .png"),
          run({"--picture", "-"}, "only --json can go to the standard output"),
          run({"--camera", "1,2,3:0,0,0"}, "--camera needs --picture"),
          run({"--picture-size", "640x360"}, "--picture-size needs --picture"),
          run({"--picture-plain"}, "--picture-plain needs --picture"),
          run({"--picture", "a.png", "--camera", "1,2,3"}, "--camera = 1,2,3, must be x,y,z:tx,ty,tz or"),
          run({"--picture", "a.png", "--picture-size", "9x9"}, "--picture-size = 9x9, must be WxH"),
          run({"--frames-dir", "film"}, "--frames-dir"),
          run({"--require", "miss_rate <"}, "must be a name or a number"),
          run({"--require", ""}, "--require"),
          run({"--affinity", "", "--executor", "threads"}, "--affinity: must not be empty"),
          run({"--picture", "a.png", "--camera", ""}, "--camera: must not be empty"),
          run({"--picture", "a.png", "--picture-size", ""}, "--picture-size: must not be empty"),
          {{"study", "order", "--deadlines", "nan"}, "must be a number >= 0.001"},
          run({"--require", "mis_rate < 1"}, "no figure of a run is called \"mis_rate\"; did you mean \"miss_rate\"?"),
      });
}

TEST(Refusals, OfBadInputEndWithThree) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("bad.json")) << "{\n  \"name\": \"x\",\n  \"dt_s\": 1e400\n}\n";
  std::ofstream(folder.file("syntax.json")) << "{\n  \"name\": \"x\",\n  \"dt_s\" 1\n}\n";
  std::ofstream(folder.file("empty.json"));
  expect_refusals(
      3, {
             {{"run", "no-such-scene"},
              "no scene of this name ships (avalanche, billiards, boulder, bullets, gallery, gas, jacks, maze, "
              "metropolis, pile, pour, real-meshes, street, two-body"},
             {{"run", "jack"}, "a file needs a path such as ./jack; did you mean \"jacks\"?"},
             {{"run", "/dev/zero"}, "is a pipe or a device, must be a file; SCENE - reads the standard input"},
             {{"run", "-"}, "standard input: the file is empty"},
             {{"run", folder.file("none.json")}, "none.json: no such file"},
             {{"run", folder.path().string()}, "is a directory, must be a scene file"},
             {{"run", folder.file("bad.json")}, "bad.json: dt_s = 1e400, cannot be represented as a double (line 3)"},
             {{"run", folder.file("syntax.json")}, "syntax.json: line 3, column 10: not valid JSON"},
             {{"run", folder.file("empty.json")}, "empty.json: the file is empty"},
         });
  EXPECT_EQ(folder.entries(), 3U);
}

// Whatever a command reads stays as it is.
TEST(Refusals, OfOutputsIntoFilesThatAreReadEndWithTwo) {
  const TemporaryFolder folder;
  const auto text_of = [&](const char* name) {
    std::ifstream file(folder.file(name));
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  std::ofstream(folder.file("scene.json")) << R"({"name": "x", "dt_s": 0.01, "frames": 2, "deadline_ms": 5,
             "camera": {"position_m": [0, -8, 2], "look_at_m": [0, 0, 0], "up": [0, 0, 1]},
             "gaze": {"file": "g.csv"},
             "materials": {"m": {"density_kgpm3": 1000}},
             "shapes": {"s": {"mesh": {"file": "four.obj", "depth": 1}}},
             "bodies": [{"shape": "s", "material": "m", "position_m": [0, 0, 0]}]})";
  std::ofstream(folder.file("g.csv")) << "time_s,x_px,y_px\n0,1,1\n";
  std::ofstream(folder.file("four.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  std::ofstream(folder.file("mine.json")) << R"({"schema": "poise.policy/1", "name": "mine", "policy": {}})";
  const std::string mesh = text_of("four.obj"), gaze = text_of("g.csv"), policy = text_of("mine.json");
  const std::string scene = folder.file("scene.json");
  const std::string record = folder.file("r.poise");
  ASSERT_EQ(poise_command({"run", scene, "--quiet", "--record", record}).exit_code, 0)
      << poise_command({"run", scene, "--quiet", "--record", record}).error;
  const std::string of_scene = "would overwrite the file that is read as a file of the scene";
  expect_refusals(
      2, {
             {{"run", scene, "--json", folder.file("four.obj")}, of_scene},
             {{"run", scene, "--states", folder.file("g.csv")}, of_scene},
             {{"run", scene, "--policy", folder.file("mine.json"), "--json", folder.file("mine.json")},
              "read as --policy"},
             {{"check", scene, "--json", folder.file("four.obj")}, of_scene},
             {{"compare", scene, "--csv", folder.file("four.obj")}, of_scene},
             {{"compare", scene, "--policies", "fifo," + folder.file("mine.json"), "--json", folder.file("mine.json")},
              "read as --policies"},
             {{"compare", scene, "--from-policy", folder.file("mine.json"), "--csv", folder.file("mine.json")},
              "read as --from-policy"},
             {{"replay", record, "--json", folder.file("four.obj")}, of_scene},
             {{"study", "cost", "--scene", scene, "--json", scene}, "read as --scene"},
         });
  EXPECT_EQ(text_of("four.obj"), mesh);
  EXPECT_EQ(text_of("g.csv"), gaze);
  EXPECT_EQ(text_of("mine.json"), policy);
}

TEST(Refusals, OfOutputEndWithFourAndLeaveNothingBehind) {
  const TemporaryFolder folder;
  expect_refusals(
      4, {
             run({"--json", folder.file("no/such/r.json")}, "cannot be written: No such file or directory"),
             run({"--states", folder.path().string()}, "cannot be written: Is a directory"),
             run({"--quiet", "--json", "/dev/full"}, "/dev/full: cannot be written: No space left on device"),
             run({"--quiet", "--states", "/dev/full"}, "/dev/full: cannot be written: No space left on device"),
             run({"--quiet", "--frames-csv", "/dev/full"}, "/dev/full: cannot be written: No space left on device"),
             run({"--quiet", "--states", folder.file("s.csv"), "--json", "/dev/full"}, "/dev/full: cannot be written"),
         });
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"run", "two-body", "--frames", "2"},
                                                    {"run", "two-body", "--frames", "2", "--quiet", "--json", "-"},
                                                    {"scenes"},
                                                    {"--version"},
                                                    {"run", "--help"}}) {
    const CommandResult result = poise_command_into("/dev/full", arguments);
    EXPECT_EQ(result.exit_code, 4) << result.error;
    EXPECT_NE(result.error.find("standard output: cannot be written"), std::string::npos) << result.error;
  }
}

}  // namespace
}  // namespace poise::testing
