// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

/// A scene of one box whose tree is built quickly. Sets POISE_TREE_CACHE for the commands and restores it.
class TreeCacheOptions : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder_.file("box.obj")) << "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nv 1 0 3\nv 1 2 3\nv 0 2 3\n"
                                              "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 2 3 7 6\nf 1 5 8 4\n";
    std::ofstream(folder_.file("box.json")) << R"({"name": "box", "dt_s": 0.01, "materials": {"m": {}},
      "shapes": {"a": {"mesh": {"file": "box.obj", "depth": 0}}}, "bodies": [{"shape": "a", "material": "m"}]})";
  }
  void TearDown() override { ::setenv("POISE_TREE_CACHE", "off", 1); }

  /// The figures of a run, and its standard error.
  std::pair<json, std::string> run(const std::vector<std::string>& options) const {
    std::vector<std::string> all{
        "run", folder_.file("box.json"), "--frames", "2", "--clock", "work", "--quiet", "--json", "-"};
    all.insert(all.end(), options.begin(), options.end());
    const CommandResult result = poise_command(all);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return {json::parse(result.out, nullptr, false), result.error};
  }
  TemporaryFolder folder_;
  TemporaryFolder cache_;
};

TEST_F(TreeCacheOptions, TheSecondRunReadsTheTreeAndMovesTheSame) {
  const auto [cold, cold_said] = run({"--tree-cache", cache_.path()});
  const auto [warm, warm_said] = run({"--tree-cache", cache_.path()});
  EXPECT_EQ(cold.at("tree_cache").at("built"), 1);
  EXPECT_EQ(warm.at("tree_cache").at("hits"), 1);
  EXPECT_EQ(cold.at("state_hash"), warm.at("state_hash"));
  EXPECT_EQ(cold_said + warm_said, "");
  EXPECT_EQ(cache_.entries(), 1U);
}

TEST_F(TreeCacheOptions, TheEnvironmentNamesTheFolderOrSwitchesItOff) {
  ::setenv("POISE_TREE_CACHE", cache_.path().c_str(), 1);
  EXPECT_EQ(run({}).first.at("tree_cache").at("built"), 1);
  EXPECT_EQ(run({}).first.at("tree_cache").at("hits"), 1);
  EXPECT_EQ(run({"--no-tree-cache"}).first.at("tree_cache").at("off"), 1);
  const TemporaryFolder other;
  EXPECT_EQ(run({"--tree-cache", other.path()}).first.at("tree_cache").at("built"), 1)
      << "the command line comes first";
  for (const char* off : {"off", ""}) {
    ::setenv("POISE_TREE_CACHE", off, 1);
    EXPECT_EQ(run({}).first.at("tree_cache").at("off"), 1) << off;
  }
}

TEST_F(TreeCacheOptions, AFolderThatCannotBeWrittenIsSaidAndTheRunGoesOn) {
  const auto [figures, said] = run({"--tree-cache", folder_.file("box.obj")});
  EXPECT_EQ(figures.at("tree_cache").at("not_writable"), 1);
  EXPECT_EQ(said, "poise run: warning: sphere trees are not kept: " + folder_.file("box.obj") +
                      " cannot be written (--no-tree-cache is silent)\n");
}

TEST_F(TreeCacheOptions, ThatContradictEachOtherAreRefused) {
  const CommandResult both = poise_command({"run", "two-body", "--tree-cache", "x", "--no-tree-cache"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_NE(both.error.find("--tree-cache has no meaning with --no-tree-cache"), std::string::npos) << both.error;
  const CommandResult empty = poise_command({"run", "two-body", "--tree-cache", ""});
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_NE(empty.error.find("--tree-cache"), std::string::npos) << empty.error;
}

}  // namespace
}  // namespace poise::testing
