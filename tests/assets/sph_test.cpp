// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "meshes.h"
#include "poise/assets/sph_file.h"

namespace poise {
namespace {

namespace fs = std::filesystem;

class SphFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("poise_sph_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Result<SphereTree> parse(const std::string& text) const {
    std::ofstream(folder_ / "a.sph", std::ios::binary) << text;
    return read_sph(folder_ / "a.sph");
  }
  std::string refusal(const std::string& text) const {
    const auto tree = parse(text);
    return tree.ok() ? "not refused" : tree.error().message;
  }
  fs::path folder_;
};

SphereTree without_protrusions(SphereTree tree) {
  std::ranges::fill(tree.protrusion_max_m, 0.0F);
  std::ranges::fill(tree.protrusion_mean_m, 0.0F);
  return tree;
}

TEST_F(SphFile, ATreeComesBackAsItWasWrittenButForItsProtrusions) {
  std::mt19937_64 random(9);
  for (const std::size_t count : {1U, 5U, 13U, 70U, 200U}) {
    std::vector<Sphere> spheres;
    for (std::size_t i = 0; i < count; ++i) {
      spheres.push_back(
          {test::random_in_box(random, Vec3::Constant(-100), Vec3::Constant(100)), 0.001 + test::uniform(random)});
    }
    const SphereTree tree = tree_of_spheres(spheres).value();
    ASSERT_TRUE(write_sph(tree, folder_ / "tree.sph").ok());
    const auto read = read_sph(folder_ / "tree.sph");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(test::same_tree(read.value(), without_protrusions(tree))) << count;
  }
}

TEST_F(SphFile, ABuiltTreeComesBackToo) {
  const SphereTree tree =
      build_sphere_tree(geometry::make_procedural_shape("l").value(), {.depth = 2, .preset = TreePreset::Fast}).value();
  ASSERT_TRUE(write_sph(tree, folder_ / "tree.sph").ok());
  EXPECT_TRUE(test::same_tree(read_sph(folder_ / "tree.sph").value(), without_protrusions(tree)));
}

TEST_F(SphFile, ANodeThatEndsEarlyIsWrittenAsItsOwnOnlyChild) {
  // Nine spheres: two levels, where groups of one end at level 1.
  std::vector<Sphere> spheres;
  for (int i = 0; i < 9; ++i) spheres.push_back({Vec3(i, 0, 0), 0.25});
  const SphereTree tree = tree_of_spheres(spheres).value();
  ASSERT_TRUE(write_sph(tree, folder_ / "tree.sph").ok());
  std::ifstream stream(folder_ / "tree.sph");
  std::string line;
  std::vector<std::string> lines;
  while (std::getline(stream, line)) lines.push_back(line);
  ASSERT_GE(lines.size(), 1U + 1 + 8 + 64);
  EXPECT_EQ(lines[1 + 1 + 8 + 64], "");
  lines.resize(1 + 1 + 8 + 64);
  EXPECT_EQ(lines[0], "3 8");
  std::size_t used = 0;
  for (std::size_t i = 10; i < lines.size(); ++i) used += lines[i] != "0 0 0 -1 0" ? 1U : 0U;
  EXPECT_EQ(used, 9U);
  for (std::size_t i = 0; i < 8; ++i) {
    const NodeIndex node = 1 + static_cast<NodeIndex>(i);
    if (tree.child_count[node] == 0) {
      EXPECT_EQ(lines[2 + i], lines[10 + 8 * i]);
    }
  }
}

TEST_F(SphFile, OtherBranchingsUnusedPlacesAndWhatFollowsAreRead) {
  for (const char* text : {"2 3\r\n0 0 0 2 1.5\n+1 0 0 1 0\n0 0 0 -1 0\n\n-1 0 0 1\nmin\n0 0 0\n",
                           "2 3\r0 0 0 2 1.5\r+1 0 0 1 0\r0 0 0 -1 0\r\r-1 0 0 1\rmin\r0 0 0\r"}) {
    const auto tree = parse(text);
    ASSERT_TRUE(tree.ok()) << tree.error().message;
    EXPECT_EQ(tree.value().node_count(), 3U);
    EXPECT_EQ(tree.value().child_count[0], 2);
    EXPECT_EQ(tree.value().sphere(2).center_m, Vec3(-1, 0, 0));
    EXPECT_EQ(tree.value().x_m.size(), 3U + kTreeBranching);
  }
}

TEST_F(SphFile, ARepeatedNodeThatBranchesFartherDownKeepsItsLevels) {
  const auto tree = parse("3 2\n0 0 0 2 1\n0 0 0 2 1\n0 0 0 -1 0\n0 0 0 1 1\n1 0 0 1 1\n0 0 0 -1 0\n0 0 0 -1 0\n");
  ASSERT_TRUE(tree.ok()) << tree.error().message;
  EXPECT_EQ(tree.value().depth(), 2);
  EXPECT_EQ(tree.value().nodes_at(1).size(), 1U);
  EXPECT_EQ(tree.value().nodes_at(2).size(), 2U);
}

TEST_F(SphFile, NumbersAreExactForWhoReadsDoubles) {
  const SphereTree tree = tree_of_spheres(std::vector<Sphere>{{Vec3(0.1, 1.0 / 3, 12345.678), 0.7}}).value();
  ASSERT_TRUE(write_sph(tree, folder_ / "tree.sph").ok());
  std::ifstream stream(folder_ / "tree.sph");
  double levels = 0;
  double branch = 0;
  Sphere read;
  stream >> levels >> branch >> read.center_m.x() >> read.center_m.y() >> read.center_m.z() >> read.radius_m;
  EXPECT_EQ(read.center_m, tree.sphere(0).center_m);
  EXPECT_EQ(read.radius_m, tree.sphere(0).radius_m);
}

TEST_F(SphFile, SaysTheErrorsOfEachLevelAfterTheRowsAsFoamReadsThem) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < 3; ++i) spheres.push_back({Vec3(i, 0, 0), 0.25});
  SphereTree tree = tree_of_spheres(spheres).value();
  tree.protrusion_max_m[0] = 4;
  for (int i = 1; i < 4; ++i) tree.protrusion_max_m[static_cast<std::size_t>(i)] = static_cast<float>(i);
  ASSERT_TRUE(write_sph(tree, folder_ / "tree.sph").ok());
  std::ifstream stream(folder_ / "tree.sph");
  std::string line;
  std::string after;
  for (int i = 0; std::getline(stream, line); ++i) after += i > 9 ? line + "\n" : "";
  EXPECT_EQ(after,
            "\nLevel 0\nNum : 1\nBest : 4\nWorst : 4\nMean : 4\n"
            "\nLevel 1\nNum : 8\nBest : 1\nWorst : 3\nMean : 2\n");
}

TEST_F(SphFile, SaysNothingOfErrorsThatNobodyMeasured) {
  const auto read = parse("2 2\n0 0 0 2 1\n1 0 0 1 1\n-1 0 0 1 1\n");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_TRUE(write_sph(read.value(), folder_ / "tree.sph").ok());
  std::ifstream stream(folder_ / "tree.sph");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_NE(text.find("\nLevel 1\nNum : 8\n"), std::string::npos) << text;
  for (const char* figure : {"Best", "Worst", "Mean"}) EXPECT_EQ(text.find(figure), std::string::npos) << text;
}

TEST_F(SphFile, AnOnlyChildThatIsSmallerStays) {
  const auto tree = parse("2 1\n0 0 0 2 1\n0 0 0 1 1\n");
  ASSERT_TRUE(tree.ok()) << tree.error().message;
  EXPECT_EQ(tree.value().node_count(), 2U);
}

TEST_F(SphFile, EachBrokenFileIsRefusedWithItsLineAndRule) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "is empty; line 1 must be 'levels branch'"},
      {"hello world\n", "line 1: must be 'levels branch'"},
      {"2\n0 0 0 1 1\n", "line 1: must be 'levels branch'"},
      {"0 8\n", "line 1: levels = 0, must be from 1 to 7"},
      {"8 8\n", "line 1: levels = 8, must be from 1 to 7"},
      {"99999999999999 8\n", "line 1: must be 'levels branch'"},
      {"2 9\n", "line 1: branch = 9, must be from 1 to 8"},
      {"2 0\n", "line 1: branch = 0, must be from 1 to 8"},
      {"1 8\n0 0 0\n", "line 2: has 3 numbers"},
      {"1 8\n0 0 0 1 1 1\n", "line 2: has 6 numbers"},
      {"1 8\n0 zero 0 1 1\n", "line 2: 'zero' must be a finite number"},
      {"1 8\n0 z\x1b[2Jo 0 1 1\n", "line 2: 'z?[2Jo' must be a finite number"},
      {"1 8\n0 nan 0 1 1\n", "line 2: 'nan' must be a finite number"},
      {"1 8\n0 0 inf 1 1\n", "line 2: 'inf' must be a finite number"},
      {"1 8\n0 0 1e400 1 1\n", "line 2: '1e400' must be a finite number"},
      {"1 8\n0 0 0 1 many\n", "line 2: occupancy 'many'"},
      {"1 8\n0 0 0 0 1\n", "line 2: radius = 0"},
      {"1 8\n0 0 0 1e20 1\n", "line 2: radius = "},
      {"1 8\n1e20 0 0 1 1\n", "line 2: coordinate = "},
      {"1 8\n0 0 0 -1 0\n", "line 2: the root must have a radius > 0"},
      {"2 2\n0 0 0 1 1\n0 0 0 1 1\n", "ends after 2 of 3 rows"},
      {"3 2\n0 0 0 1 1\n0 0 0 -1 0\n0 0 0 1 1\n0 0 0 1 1\n", "line 5: node 3 is used, but its parent 1 is not"},
  };
  for (const auto& [text, rule] : cases) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find(rule), std::string::npos) << text << " -> " << message;
    EXPECT_NE(message.find("a.sph: "), std::string::npos) << message;
  }
}

TEST_F(SphFile, MissingFilesAndFoldersAreRefused) {
  EXPECT_NE(read_sph(folder_ / "missing.sph").error().message.find("no such file"), std::string::npos);
  EXPECT_FALSE(read_sph(folder_).ok());
}

TEST_F(SphFile, AFileThatCannotBeWrittenLeavesNothingBehind) {
  const SphereTree tree = tree_of_spheres(std::vector<Sphere>{{Vec3::Zero(), 1}}).value();
  fs::create_directories(folder_ / "taken.sph" / "inside");
  for (const fs::path& file : {folder_ / "nowhere" / "a.sph", folder_ / "taken.sph", fs::path("/dev/full")}) {
    const Status written = write_sph(tree, file);
    ASSERT_FALSE(written.ok()) << file;
    EXPECT_EQ(written.error().kind, ErrorKind::OutputFailed);
    EXPECT_EQ(written.error().message.find(file.string() + ": cannot be written"), 0U) << written.error().message;
  }
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_EQ(entry.path().filename(), "taken.sph");
  EXPECT_FALSE(write_sph({}, folder_ / "empty.sph").ok());
}

}  // namespace
}  // namespace poise
