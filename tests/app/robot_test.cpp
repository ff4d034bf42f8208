// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "poise/assets/tree_formats.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

const std::string kArm = POISE_SOURCE_DIR "/scenes/robots/arm.urdf";

CommandResult robot(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "tree");
  arguments.insert(arguments.end(), {"--samples", "500", "--preset", "fast", "--depth", "1"});
  return poise_command(arguments);
}

// The example of docs/my-robots.md.
TEST(RobotCommand, GivesTreesOfAllLinksAndWritesThemBack) {
  const TemporaryFolder folder;
  const std::string written = folder.file("spheres.urdf");
  const CommandResult result = robot({kArm, "-o", written, "--level", "1", "--json", folder.file("arm.json")});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* part : {"arm.urdf: 5 links, 3 with a tree", "\nbase    collision", "\nhand    visual",
                           "\ntip     spheres\n", "\nflange  none\n", "largest protrusion"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
  const json links = json::parse(contents(folder.file("arm.json"))).at("links");
  ASSERT_EQ(links.size(), 5U);
  for (const std::size_t link : {0U, 1U, 2U}) {
    const json& level = links[link].at("tree").at("levels").at(1);
    EXPECT_EQ(level.at("surface_coverage"), 1);
    const auto spheres = read_spheres(written, {links[link].at("name"), {}});
    ASSERT_TRUE(spheres.ok()) << spheres.error().message;
    EXPECT_EQ(spheres.value().size(), level.at("spheres"));
  }
  EXPECT_EQ(links[3].at("shapes"), "spheres");
  EXPECT_EQ(links[3].at("tree"), nullptr);
  const auto tip = read_spheres(written, {"tip", {}});
  ASSERT_TRUE(tip.ok()) << tip.error().message;
  EXPECT_EQ(tip.value().at(0).radius_m, 0.05) << "a sphere stays as it is";
  EXPECT_NE(contents(written).find("<limit lower=\"-3.14\""), std::string::npos);
  // The box of 0.3 x 0.3 x 0.1 m and the L, which a quarter turn about x puts upright: both are in the tree of the
  // link.
  double lowest = 1;
  double highest = 0;
  const auto upper = read_spheres(written, {"upper", {}});
  ASSERT_TRUE(upper.ok()) << upper.error().message;
  for (const Sphere& s : upper.value()) {
    lowest = std::min(lowest, s.center_m.z() - s.radius_m);
    highest = std::max(highest, s.center_m.z() + s.radius_m);
  }
  EXPECT_LE(lowest, 0);
  EXPECT_GE(highest, 0.4 + 0.4);
}

TEST(RobotCommand, FindsPackagesWhereItIsTold) {
  const TemporaryFolder folder;
  const std::string file = folder.file("r.urdf");
  std::ofstream(file) << "<robot><link name='a'>\n<collision><geometry><mesh filename='package://parts/slab.obj'/>"
                         "</geometry></collision></link></robot>";
  const CommandResult unknown = robot({file});
  EXPECT_EQ(unknown.exit_code, 3);
  EXPECT_EQ(unknown.error, "poise tree: " + file +
                               ": line 2: link 'a': 'package://parts/slab.obj': no folder 'parts' beside or above the "
                               "URDF, --package parts=FOLDER names it\n");
  EXPECT_EQ(robot({file, "--package", "parts=" POISE_SOURCE_DIR "/scenes/meshes", "--quiet"}).exit_code, 0);
  const CommandResult missing = robot({file, "--package", "parts=" + folder.path().string()});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_EQ(missing.error, "poise tree: " + file + ": line 2: link 'a': " + folder.file("slab.obj") +
                               ": cannot be read: no such file\n");
  std::filesystem::create_directory(folder.file("parts"));
  std::filesystem::copy_file(POISE_SOURCE_DIR "/scenes/meshes/slab.obj", folder.file("parts/slab.obj"));
  EXPECT_EQ(robot({file, "--quiet"}).exit_code, 0) << "beside the file";
}

TEST(RobotCommand, RefusesWhatHasNoMeaning) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{kArm, kArm}, "one robot at a time"},
      {{kArm, "-o", "a.sph"}, "-o a.sph: of a robot a .urdf is written"},
      {{kArm, "--scale", "2"}, "--scale has no meaning with a robot"},
      {{kArm, "--tree", "a.sph"}, "--tree has no meaning with a robot"},
      {{kArm, "--package", "parts"}, "--package = 'parts', must be NAME=FOLDER"},
      {{kArm, "-o", "a.urdf", "--level", "2"}, "--level 2 is below --depth 1"},
      {{POISE_SOURCE_DIR "/scenes/meshes/slab.obj", "--package", "a=b"}, "--package has no meaning but with a robot"},
  };
  for (const auto& [arguments, message] : cases) {
    const CommandResult result = robot(arguments);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  }
}

}  // namespace
}  // namespace poise::testing
