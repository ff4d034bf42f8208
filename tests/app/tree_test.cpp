// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

const std::string kSlab = POISE_SOURCE_DIR "/scenes/meshes/slab.obj";
const std::string kTorus = POISE_SOURCE_DIR "/scenes/meshes/torus.obj";

/// Runs `poise tree` with these arguments, and few samples to be fast.
CommandResult tree(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "tree");
  arguments.insert(arguments.end(), {"--samples", "500"});
  return poise_command(arguments);
}

json figures(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--json", "-"});
  const CommandResult result = tree(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return json::parse(result.out, nullptr, false);
}

/// A tree of one ball that is much too small to cover anything.
std::string leaking_tree(const TemporaryFolder& folder) {
  std::ofstream(folder.file("leaking.sph")) << "1 8\n0 0 0 0.3 1\n";
  return folder.file("leaking.sph");
}

TEST(TreeCommand, BuildsJudgesAndTellsItAsATable) {
  const CommandResult result = tree({kSlab, "--depth", "1", "--preset", "fast"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "") << "no progress where stderr is no terminal";
  for (const char* part :
       {"slab.obj: 12 triangles", "preset fast to depth 1", "bytes", "CPU time", "largest protrusion", "100.0000"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
  EXPECT_EQ(result.out.find("leaks"), std::string::npos) << result.out;
  EXPECT_EQ(tree({kSlab, "--depth", "0", "--quiet"}).out, "");
}

TEST(TreeCommand, TellsTheSameToPrograms) {
  const json found = figures({kSlab, "--depth", "1", "--seed", "5", "--threads", "1"});
  EXPECT_EQ(found.at("schema"), "poise.tree/2");
  EXPECT_EQ(found.at("triangles"), 12);
  EXPECT_EQ(found.at("depth"), 1);
  EXPECT_EQ(found.at("preset"), "default");
  EXPECT_EQ(found.at("seed"), 5);
  EXPECT_EQ(found.at("samples"), 500);
  EXPECT_NEAR(found.at("volume_m3").get<double>(), 0.06, 1e-9);
  EXPECT_GT(found.at("build_cpu_ms").get<double>(), 0);
  EXPECT_GT(found.at("build_peak_bytes").get<double>(), 1e6);
  EXPECT_EQ(found.at("leaks"), false);
  ASSERT_EQ(found.at("levels").size(), 2U);
  EXPECT_EQ(found.at("levels").at(1).at("surface_coverage"), 1);
}

TEST(TreeCommand, WhatItWritesIsJudgedLikeWhatItBuilt) {
  const TemporaryFolder folder;
  const std::string file = folder.file("slab.sph");
  const json built = figures({kSlab, "--depth", "2", "--preset", "fast", "-o", file});
  const json read = figures({kSlab, "--tree", file});
  EXPECT_EQ(read.at("tree"), file);
  EXPECT_TRUE(read.at("build_ms").is_null());
  EXPECT_EQ(read.at("depth"), 2);
  EXPECT_EQ(read.at("nodes"), built.at("nodes"));
  for (std::size_t level = 0; level < 3; ++level) {
    for (const char* figure :
         {"spheres", "protrusion_max_m", "protrusion_mean_m", "volume_ratio", "surface_coverage"}) {
      EXPECT_EQ(read.at("levels").at(level).at(figure), built.at("levels").at(level).at(figure)) << figure;
    }
  }
}

TEST(TreeCommand, SaysThatAForeignTreeLeaksAndFailsOnlyWhereAsked) {
  const TemporaryFolder folder;
  const std::string file = leaking_tree(folder);
  const CommandResult told = tree({kSlab, "--tree", file});
  EXPECT_EQ(told.exit_code, 0) << told.error;
  EXPECT_NE(told.out.find("leaking.sph leaks at level 0"), std::string::npos) << told.out;
  const CommandResult required = tree({kSlab, "--tree", file, "--require-coverage"});
  EXPECT_EQ(required.exit_code, 1);
  EXPECT_EQ(required.error, "poise tree: --require-coverage: a tree leaks\n");
  EXPECT_EQ(tree({kSlab, "--depth", "1", "--preset", "fast", "--require-coverage"}).exit_code, 0);
  EXPECT_EQ(tree({kSlab, "--depth", "1", "--preset", "fast", "--compare", file, "--require-coverage"}).exit_code, 1);
}

TEST(TreeCommand, SetsTwoTreesSideBySideAndMarksTheBetterFigure) {
  const TemporaryFolder folder;
  const std::string deep = folder.file("deep.sph");
  const json built = figures({kSlab, "--depth", "2", "--preset", "fast", "-o", deep});
  const json compared = figures({kSlab, "--depth", "1", "--preset", "fast", "--compare", deep});
  ASSERT_EQ(compared.at("trees").size(), 2U);
  EXPECT_EQ(compared.at("trees").at(0).at("tree"), "built");
  ASSERT_EQ(compared.at("trees").at(1).at("levels").size(), 3U);
  for (std::size_t level = 0; level < 3; ++level) {
    for (const char* figure : {"spheres", "protrusion_max_m", "volume_ratio"}) {
      EXPECT_EQ(compared.at("trees").at(1).at("levels").at(level).at(figure), built.at("levels").at(level).at(figure))
          << figure;
    }
  }
  const CommandResult table = tree({kSlab, "--tree", deep, "--compare", leaking_tree(folder)});
  EXPECT_EQ(table.exit_code, 0) << table.error;
  const std::vector<std::string> rows = lines(table.out);
  const auto last =
      std::find_if(rows.begin(), rows.end(), [](const std::string& row) { return row.rfind("    2 ", 0) == 0; });
  ASSERT_NE(last, rows.end()) << table.out;
  EXPECT_NE(last->find("100.0000*"), std::string::npos) << "the whole tree covers better: " << *last;
  EXPECT_NE(table.out.find("leaking.sph leaks"), std::string::npos);
}

TEST(TreeCommand, ConvertsWithoutAMesh) {
  const TemporaryFolder folder;
  const std::string first = folder.file("first.sph");
  ASSERT_EQ(tree({kSlab, "--depth", "1", "--preset", "fast", "-o", first}).exit_code, 0);
  const CommandResult result = poise_command({"tree", "--tree", first, "-o", folder.file("second.sph")});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.out, "");
  // Below the rows are figures that a tree from a file does not have.
  const auto rows = [](const std::string& text) { return text.substr(0, text.find("\n\n")); };
  EXPECT_EQ(lines(rows(contents(first))).size(), 10U);
  EXPECT_EQ(rows(contents(folder.file("second.sph"))), rows(contents(first)));
}

TEST(TreeCommand, WritesALevelForRobotToolsAndJudgesSuchFilesToo) {
  const TemporaryFolder folder;
  const json built = figures({kSlab, "--depth", "2", "--preset", "fast", "-o", folder.file("slab.sph")});
  for (const char* name : {"slab.urdf", "slab.yml", "slab.json"}) {
    const CommandResult result =
        poise_command({"tree", "--tree", folder.file("slab.sph"), "-o", folder.file(name), "--level", "1"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    const json read = figures({kSlab, "--tree", folder.file(name)});
    const json& level = read.at("levels").back();
    EXPECT_EQ(level.at("spheres"), built.at("levels").at(1).at("spheres")) << name;
    EXPECT_EQ(level.at("protrusion_max_m"), built.at("levels").at(1).at("protrusion_max_m")) << name;
  }
}

/// One tall triangle, its top along +y.
std::string tall_gltf(const TemporaryFolder& folder) {
  std::ofstream(folder.file("tall.gltf"))
      << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],)"
      << R"("meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "bufferViews": [{"buffer": 0, "byteLength": 36}],)"
      << R"("buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAPwAAAAAAAAAAAAAAAAAAQEAAAIA+"}],)"
      << R"("accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",)"
      << R"("min": [0, 0, 0], "max": [0.5, 3, 0.25]}]})";
  return folder.file("tall.gltf");
}

TEST(TreeCommand, DrawsFromTheSideThatIsAskedForAndGltfWithYUpward) {
  const TemporaryFolder folder;
  const std::string mesh = tall_gltf(folder);
  const auto picture = [&](std::vector<std::string> options) {
    const std::string file = folder.file("tree.png");
    options.insert(options.begin(), {mesh, "--depth", "0", "--quiet", "--picture", file});
    const CommandResult result = tree(options);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return contents(file);
  };
  const std::string usual = picture({});
  EXPECT_EQ(usual, picture({"--up", "y", "--front", "z"}));
  EXPECT_NE(usual, picture({"--up", "z"}));
  EXPECT_NE(usual, picture({"--front", "-z"}));
}

TEST(TreeCommand, DrawsItsTrees) {
  const TemporaryFolder folder;
  const std::string file = folder.file("tree.png");
  const CommandResult result = tree({kSlab, "--depth", "0", "--picture", file, "--up", "y", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const std::string png = contents(file);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_EQ(static_cast<unsigned char>(png[18]) * 256 + static_cast<unsigned char>(png[19]), 1800);
}

TEST(TreeCommand, ShowsProgressOnATerminalAndEndsAtASignalWithNothingWritten) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const TemporaryFolder folder;
    const CommandResult result =
        interrupted_on_terminal({"tree", kTorus, "--depth", "3", "-o", folder.file("t.sph"), "--json",
                                 folder.file("t.json"), "--picture", folder.file("t.png")},
                                signal);
    EXPECT_EQ(result.exit_code, 128 + signal) << result.error;
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.error.find("reading the mesh"), std::string::npos) << result.error;
    const std::string name = signal == SIGINT ? "Ctrl-C" : "SIGTERM";
    EXPECT_NE(result.error.find("poise tree: stopped by " + name + "; nothing was written"), std::string::npos)
        << result.error;
    EXPECT_EQ(folder.entries(), 0U);
  }
}

TEST(TreeCommand, TakesOpenMeshesAndSheetsAndSaysSo) {
  const TemporaryFolder folder;
  // A cube without its top, and a square.
  std::ofstream(folder.file("box.obj")) << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                                           "f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  std::ofstream(folder.file("square.obj")) << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  const json box = figures({folder.file("box.obj"), "--depth", "1", "--preset", "fast", "--require-coverage"});
  EXPECT_EQ(box.at("closed"), false);
  EXPECT_EQ(box.at("solidity"), "solid");
  EXPECT_NE(box.at("mesh_report").get<std::string>().find("open"), std::string::npos) << box.at("mesh_report");
  const json square = figures({folder.file("square.obj"), "--depth", "1", "--preset", "fast", "--require-coverage"});
  EXPECT_EQ(square.at("solidity"), "shell");
  EXPECT_EQ(square.at("levels").at(1).at("volume_ratio"), 0);
  const json shell = figures({kSlab, "--depth", "1", "--preset", "fast", "--shell"});
  EXPECT_EQ(shell.at("solidity"), "shell");
  EXPECT_EQ(shell.at("closed"), true);
  const CommandResult table = tree({folder.file("square.obj"), "--depth", "0"});
  EXPECT_NE(table.out.find("taken as a shell"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("100.0000          -        -\n"), std::string::npos)
      << "no inside and no volume: " << table.out;
}

TEST(TreeCommand, TellsWhatMeshesAreARowEach) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("open.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
  std::ofstream(folder.file("words.obj")) << "these are no triangles\n";
  std::ofstream(folder.file("sheet.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::vector<std::string> files{kSlab, folder.file("open.obj"), folder.file("sheet.obj"),
                                       folder.file("words.obj")};
  const CommandResult table = poise_command({"tree", "--inspect", files[0], files[1], files[2], files[3]});
  EXPECT_EQ(table.exit_code, 0) << table.error;
  const CommandResult result =
      poise_command({"tree", "--inspect", files[0], files[1], files[2], files[3], "--json", "-"});
  const json found = json::parse(result.out, nullptr, false);
  ASSERT_EQ(found.at("rows").size(), 4U);
  const char* reports[] = {"closed", "open", "sheet", "refused"};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(found.at("rows").at(i).at("file"), files[i]);
    EXPECT_EQ(found.at("rows").at(i).at("kind"), reports[i]);
    EXPECT_NE(table.out.find(found.at("rows").at(i).at("why").get<std::string>()), std::string::npos) << table.out;
  }
  EXPECT_EQ(poise_command({"tree", "--inspect", files[3]}).exit_code, 3) << "nothing could be read";
}

}  // namespace
}  // namespace poise::testing
