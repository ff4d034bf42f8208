// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

const std::string kSlab = POISE_SOURCE_DIR "/scenes/meshes/slab.obj";

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

Case of_mesh(std::vector<std::string> options, const std::string& message) {
  options.insert(options.begin(), {"tree", kSlab});
  return {options, message};
}

TEST(TreeRefusals, OfOptionsThatHaveNoMeaningTogetherEndWithTwo) {
  expect_refusals(
      2,
      {
          {{"tree"}, "a MESH to build a tree of, or --tree FILE to convert, is required"},
          {{"tree", kSlab, kSlab}, "only --inspect takes more than one"},
          {{"tree", "--tree", "a.sph"}, "--tree without a MESH converts, and needs -o FILE"},
          {{"tree", "--tree", "a.sph", "-o", "b.sph", "--json", "c.json"}, "--json needs a MESH"},
          {{"tree", "--tree", "a.sph", "-o", "b.sph", "--picture", "c.png"}, "--picture needs a MESH"},
          {{"tree", "--tree", "a.sph", "-o", "b.sph", "--depth", "2"}, "--depth needs a MESH"},
          {{"tree", "--tree", "a.sph", "-o", "b.sph", "--compare", "c.sph"}, "--compare needs a MESH"},
          {{"tree", "--inspect"}, "--inspect needs a MESH"},
          of_mesh({"--inspect", "--depth", "1"}, "--depth has no meaning with --inspect"),
          of_mesh({"--inspect", "-o", "a.sph"}, "-o has no meaning with --inspect"),
          of_mesh({"--tree", "a.sph", "--depth", "2"}, "--depth has no meaning with --tree"),
          of_mesh({"--tree", "a.sph", "--preset", "best"}, "--preset has no meaning with --tree"),
          of_mesh({"--tree", "a.sph", "--compare", "b.sph", "-o", "c.sph"}, "which of the two trees is meant?"),
          of_mesh({"--level", "1"}, "--level needs -o with a .urdf"),
          of_mesh({"-o", "a.sph", "--level", "1"}, "--level needs -o with a .urdf"),
          of_mesh({"-o", "a.txt"}, "-o a.txt: the ending must be .sph, .urdf, .yml, .yaml or .json"),
          of_mesh({"-o", "-"}, "only --json can go to the standard output"),
          of_mesh({"--picture", "-"}, "only --json can go to the standard output"),
          of_mesh({"--json", "a.json", "-o", "./a.json"}, "named for two outputs"),
          of_mesh({"--json", ""}, "--json: must not be empty"),
          of_mesh({"-o", ""}, "--output: must not be empty"),
          of_mesh({"--tree", ""}, "--tree: must not be empty"),
          of_mesh({"--picture", "a.jpg"}, "--picture a.jpg: a PNG is written, so the ending must be .png"),
          of_mesh({"--depth", "1", "--level", "2", "-o", "a.urdf"}, "--level 2 is below --depth 1"),
          of_mesh({"--level", "4", "-o", "a.urdf"}, "--level 4 is below --depth 3"),
          of_mesh({"--up", "y"}, "--up needs --picture"),
          of_mesh({"--front", "-y"}, "--front needs --picture"),
          of_mesh({"--front", "-y", "--up", "y", "--picture", "a.png"}, "--front -y and --up y must be different axes"),
          of_mesh({"--front", "-z", "--picture", "a.png"}, "--front -z and --up z must be different axes"),
          of_mesh({"--inspect", "--front", "x"}, "--front has no meaning with --inspect"),
          of_mesh({"--up", "w", "--picture", "a.png"}, "--up"),
          of_mesh({"--preset", "slow"}, "--preset"),
          of_mesh({"--depth", "7"}, "--depth = 7, must be a whole number from 0 to 6"),
          of_mesh({"--samples", "0"}, "--samples = 0, must be a whole number from 1 to 100000000"),
          of_mesh({"--scale", "0"}, "--scale = 0, must be a number > 0"),
      });
}

TEST(TreeRefusals, AnOutputThatIsAlsoReadStaysAsItIs) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("ball.sph")) << "1 8\n0 0 0 1 1\n";
  std::filesystem::create_symlink(folder.file("ball.sph"), folder.file("link.sph"));
  const std::string mesh = folder.file("slab.obj");
  std::filesystem::copy_file(kSlab, mesh);
  expect_refusals(2,
                  {
                      {{"tree", mesh, "--depth", "0", "--json", mesh}, "would overwrite the file that is read as MESH"},
                      {{"tree", mesh, "--inspect", "--json", folder.file("./slab.obj")},
                       "would overwrite the file that is read as MESH"},
                      {{"tree", "--tree", folder.file("ball.sph"), "-o", folder.file("link.sph")},
                       "would overwrite the file that is read as --tree"},
                      of_mesh({"--compare", folder.file("ball.sph"), "-o", folder.file("ball.sph")},
                              "would overwrite the file that is read as --compare"),
                  });
  EXPECT_EQ(contents(folder.file("ball.sph")), "1 8\n0 0 0 1 1\n");
  EXPECT_EQ(contents(mesh), contents(kSlab));
}

TEST(TreeRefusals, OfBadInputEndWithThree) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("bad.sph")) << "1 8\n0 0 zero 1 1\n";
  std::ofstream(folder.file("ball.sph")) << "1 8\n0 0 0 1 1\n";
  expect_refusals(3, {
                         {{"tree", folder.file("none.obj")}, "none.obj"},
                         of_mesh({"--tree", folder.file("none.sph")}, "none.sph"),
                         of_mesh({"--tree", folder.file("bad.sph")}, "bad.sph"),
                         of_mesh({"--tree", folder.file("bad.txt")}, "bad.txt: the ending must be .sph, .urdf"),
                         {{"tree", "--tree", folder.file("bad.sph"), "-o", folder.file("b.sph")}, "bad.sph"},
                         {{"tree", "--tree", folder.file("ball.sph"), "-o", folder.file("b.urdf"), "--level", "1"},
                          "ball.sph: has no level 1, its deepest is 0"},
                         of_mesh({"--tree", folder.file("ball.sph"), "-o", folder.file("b.urdf"), "--level", "1"},
                                 "ball.sph: has no level 1, its deepest is 0"),
                     });
  EXPECT_EQ(folder.entries(), 2U);
}

TEST(TreeRefusals, OfOutputEndWithFourAndLeaveNothingBehind) {
  const TemporaryFolder folder;
  expect_refusals(4, {
                         of_mesh({"--json", folder.file("no/such/r.json")}, "no/such/r.json"),
                         of_mesh({"-o", folder.file("no/such/t.sph")}, "no/such/t.sph"),
                         of_mesh({"--picture", folder.file("no/such/t.png")}, "no/such/t.png"),
                         of_mesh({"--inspect", "--json", folder.file("no/such/v.json")}, "no/such/v.json"),
                         of_mesh({"--depth", "0", "--quiet", "--json", "/dev/full"}, "/dev/full"),
                     });
  EXPECT_EQ(folder.entries(), 0U);
}

}  // namespace
}  // namespace poise::testing
