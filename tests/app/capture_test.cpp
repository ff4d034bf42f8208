// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "capture/capture_reader.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using capture::CaptureReader;
using capture::PackedFrame;
using nlohmann::json;

CaptureReader opened(const std::string& file) {
  Result<CaptureReader> reader = CaptureReader::open(file);
  EXPECT_TRUE(reader.ok()) << reader.error().message;
  return std::move(reader).value();
}

std::vector<PackedFrame> frames_of(CaptureReader& reader) {
  std::vector<PackedFrame> frames;
  EXPECT_TRUE(reader.read_frames(0, UINT64_MAX, [&](const PackedFrame& frame) {
    frames.push_back(frame);
    return true;
  }));
  return frames;
}

/// Expects the poses of a table of states, of all of its frames and bodies.
void expect_states(const std::string& csv, CaptureReader& reader) {
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> rows;
  for (const std::string& line : lines(contents(csv))) {
    const std::vector<std::string> row = cells(line);
    rows[{row[0], row[2]}] = row;
  }
  const double half = reader.header().position_step_m / 2 * (1 + 1e-9);
  std::size_t compared = 0;
  for (const PackedFrame& frame : frames_of(reader)) {
    for (std::size_t i = 0; i < frame.rows.size(); ++i) {
      const auto found =
          rows.find({std::to_string(frame.facts.frame), std::to_string(reader.bodies()[frame.rows[i]].number)});
      ASSERT_NE(found, rows.end()) << frame.facts.frame;
      const auto cell = [&](std::size_t column) { return std::stod(found->second[column]); };
      const capture::Pose pose = reader.pose(frame.poses[i]);
      ASSERT_LE((pose.position_m - Vec3(cell(3), cell(4), cell(5))).cwiseAbs().maxCoeff(), half);
      ASSERT_LE(pose.orientation.angularDistance(Quat(cell(6), cell(7), cell(8), cell(9))),
                capture::orientation_error_rad(reader.header().orientation_steps));
      ++compared;
    }
  }
  EXPECT_EQ(compared + 1, rows.size()) << "every row but the names of the columns";
}

TEST(Capture, HasEveryBodyOfEveryFrameOfARunThatPoursThem) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.capture");
  const CommandResult run =
      poise_command({"run", "pour", "--bodies", "100", "--frames", "90", "--clock", "work", "--capture", file,
                     "--capture-contacts", "--states", folder.file("run.csv"), "--json", folder.file("run.json")});
  EXPECT_EQ(run.exit_code, 0) << run.error;
  EXPECT_NE(run.out.find("\ncapture        91 frames, "), std::string::npos) << run.out;
  const json report = json::parse(contents(folder.file("run.json")), nullptr, false);
  EXPECT_EQ(report.at("capture").at("file"), file);
  EXPECT_EQ(report.at("capture").at("frames"), 91);
  EXPECT_EQ(report.at("capture").at("left_out"), 0);
  EXPECT_EQ(report.at("capture").at("bytes"), contents(file).size());
  CaptureReader reader = opened(file);
  EXPECT_FALSE(reader.damage());
  EXPECT_EQ(reader.header().scene, "pour");
  EXPECT_EQ(reader.header().command.at(1), "run");
  EXPECT_FALSE(reader.header().deadline_ms);
  EXPECT_GT(reader.bodies().size(), frames_of(reader).front().rows.size()) << "bodies came";
  expect_states(folder.file("run.csv"), reader);
  EXPECT_FALSE(frames_of(reader).back().contacts.empty());
}

TEST(Capture, OfADeadlineHasTheTimesAndCausesOfTheRunAndSoHasThatOfItsReplay) {
  const TemporaryFolder folder;
  const CommandResult run = poise_command({"run", "jacks", "--bodies", "60", "--frames", "40", "--warmup", "5",
                                           "--deadline", "1", "--record", folder.file("run.poise"), "--capture",
                                           folder.file("run.capture"), "--frames-csv", folder.file("frames.csv")});
  EXPECT_EQ(run.exit_code, 0) << run.error;
  const CommandResult replay =
      poise_command({"replay", folder.file("run.poise"), "--capture", folder.file("again.capture"), "--quiet"});
  EXPECT_EQ(replay.exit_code, 0) << replay.error;
  CaptureReader a = opened(folder.file("run.capture"));
  CaptureReader b = opened(folder.file("again.capture"));
  EXPECT_EQ(a.header().deadline_ms, 1);
  EXPECT_EQ(b.header().deadline_ms, 1);
  EXPECT_EQ(b.header().threads, a.header().threads);
  EXPECT_EQ(b.header().policy, a.header().policy);
  EXPECT_EQ(b.header().contact, "fitted");
  const std::vector<PackedFrame> of_run = frames_of(a);
  const std::vector<PackedFrame> of_replay = frames_of(b);
  ASSERT_EQ(of_run.size(), 46U);
  ASSERT_EQ(of_replay.size(), 46U);
  for (std::size_t k = 0; k < of_run.size(); ++k) {
    EXPECT_EQ(of_replay[k].poses, of_run[k].poses) << k;
    EXPECT_EQ(of_replay[k].activity, of_run[k].activity) << k;
    EXPECT_EQ(of_replay[k].level, of_run[k].level) << k;
    EXPECT_EQ(of_replay[k].facts.lateness, of_run[k].facts.lateness) << k;
    EXPECT_EQ(of_replay[k].facts.cause, of_run[k].facts.cause) << k;
    EXPECT_EQ(of_replay[k].facts.times[5], of_run[k].facts.times[5]) << "solve of " << k;
    EXPECT_EQ(of_run[k].facts.warm_up, k >= 1 && k <= 5) << k;
  }
  // The figures of the capture are those of the run's own table.
  const CommandResult exported = poise_command({"export", folder.file("run.capture"), "--csv", "-"});
  EXPECT_EQ(exported.exit_code, 0) << exported.error;
  const std::vector<std::string> rows = lines(exported.out);
  const std::vector<std::string> own = lines(contents(folder.file("frames.csv")));
  ASSERT_EQ(rows.size(), 47U);
  ASSERT_EQ(own.size(), 46U);
  const auto column = [](const std::vector<std::string>& table, std::size_t row, const std::string& name) {
    const std::vector<std::string> names = cells(table[0]);
    const auto at = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    return at < names.size() ? cells(table[row])[at] : "no column " + name;
  };
  for (std::size_t k = 1; k <= 45; ++k) {
    for (const char* name : {"candidate_pairs", "coarse_pairs", "contact_pairs", "pairs_left", "jobs_done"})
      EXPECT_EQ(column(rows, k + 1, name), column(own, k, name)) << name << " of frame " << k;
    for (const char* name : {"kinetic_j", "potential_j", "momentum_x_kgmps", "momentum_y_kgmps", "momentum_z_kgmps"}) {
      const double exact = std::stod(column(own, k, name));
      EXPECT_NEAR(std::stod(column(rows, k + 1, name)), exact, 1e-6 * std::abs(exact)) << name << " of frame " << k;
    }
    EXPECT_EQ(of_replay[k].facts.momentum_ns, of_run[k].facts.momentum_ns) << k;
  }
}

TEST(Capture, TakesAtMost10KilobytesFor10000BodiesAndFramesOfASettledHeapAnd150OfAFallingOne) {
  const TemporaryFolder folder;
  EXPECT_EQ(poise_command({"run", "jacks", "--bodies", "300", "--frames", "720", "--clock", "work", "--capture",
                           folder.file("a"), "--quiet"})
                .exit_code,
            0);
  const CaptureReader reader = opened(folder.file("a"));
  ASSERT_GE(reader.blocks().size(), 4U);
  const auto bytes_each = [&](std::size_t block, std::size_t past) {
    const double bytes = static_cast<double>(reader.blocks()[past].at - reader.blocks()[block].at);
    const double frames = static_cast<double>(reader.blocks()[past].first_frame - reader.blocks()[block].first_frame);
    return bytes / (frames * static_cast<double>(reader.bodies().size()));
  };
  for (std::size_t block = 0; block + 1 < reader.blocks().size(); ++block)
    EXPECT_LT(bytes_each(block, block + 1), 15) << "block " << block;
  const std::size_t last = reader.blocks().size() - 1;
  EXPECT_LT(bytes_each(last - 2, last), 1.0) << "the last 120 frames";
}

TEST(Capture, OfAPacedRunAddsUp) {
  const TemporaryFolder folder;
  const CommandResult run = poise_command(
      {"run", "two-body", "--frames", "20", "--paced", "--capture", folder.file("a"), "--json", "-", "--quiet"});
  EXPECT_EQ(run.exit_code, 0) << run.error;
  const json report = json::parse(run.out, nullptr, false);
  EXPECT_EQ(report.at("capture").at("frames").get<int>() + report.at("capture").at("left_out").get<int>(), 21);
  EXPECT_TRUE(opened(folder.file("a")).header().paced);
}

TEST(Capture, IsNotMadeWithoutTheOption) {
  const CommandResult run = poise_command({"run", "two-body", "--frames", "2", "--json", "-", "--quiet"});
  EXPECT_TRUE(json::parse(run.out, nullptr, false).at("capture").is_null());
}

TEST(Capture, SaysWhenItsStepsDoNotReachABody) {
  const TemporaryFolder folder;
  const std::string file = folder.file("a.capture");
  const CommandResult run =
      poise_command({"run", "two-body", "--frames", "2", "--quiet", "--capture", file, "--capture-step", "1e-20"});
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_NE(run.error.find(file + ": body "), std::string::npos) << run.error;
  EXPECT_NE(run.error.find("--capture-step takes longer ones"), std::string::npos) << run.error;
}

TEST(Capture, RefusesOptionsThatDoNotBelongTogether) {
  const TemporaryFolder folder;
  const auto refused = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"run", "two-body", "--frames", "2", "--quiet"});
    const CommandResult result = poise_command(arguments);
    return std::to_string(result.exit_code) + " " + result.error;
  };
  EXPECT_EQ(refused({"--capture-pairs"}), "2 poise run: --capture-pairs needs --capture\n");
  EXPECT_EQ(refused({"--capture-contacts"}), "2 poise run: --capture-contacts needs --capture\n");
  EXPECT_EQ(refused({"--capture-step", "0.1"}), "2 poise run: --capture-step needs --capture\n");
  EXPECT_EQ(refused({"--capture", "-"}), "2 poise run: only --json can go to the standard output\n");
  EXPECT_EQ(refused({"--states-every", "2"}), "2 poise run: --states-every needs --states\n");
  const std::string file = folder.file("a");
  EXPECT_EQ(refused({"--capture", file, "--states", file}),
            "2 poise run: " + file + " is named for two outputs: --states and --capture\n");
  EXPECT_EQ(refused({"--capture", folder.file("no/a")}),
            "4 poise run: " + folder.file("no/a") + ": cannot be written: No such file or directory\n");
}

TEST(States, OfEachNthFrameAloneAreThoseOfAllFrames) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& file, const std::string& every) {
    EXPECT_EQ(poise_command({"run", "jacks", "--bodies", "20", "--frames", "12", "--clock", "work", "--states", file,
                             "--states-every", every, "--quiet"})
                  .exit_code,
              0);
    return lines(contents(file));
  };
  const std::vector<std::string> all = run(folder.file("all.csv"), "1");
  std::vector<std::string> expected;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 || std::stoul(cells(all[i])[0]) % 5 == 0) expected.push_back(all[i]);
  }
  EXPECT_EQ(run(folder.file("some.csv"), "5"), expected);
  EXPECT_EQ(expected.size(), 1U + 3 * 25) << "frames 0, 5 and 10";
}

class Export : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = folder_.file("run.capture");
    const CommandResult run = poise_command(
        {"run", "jacks", "--bodies", "20", "--frames", "100", "--clock", "work", "--capture", file_, "--quiet"});
    ASSERT_EQ(run.exit_code, 0) << run.error;
  }
  std::string refused(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"export", file_});
    const CommandResult result = poise_command(arguments);
    return std::to_string(result.exit_code) + " " + result.error;
  }
  TemporaryFolder folder_;
  std::string file_;
};

TEST_F(Export, WritesGltfParaviewAndFigures) {
  const CommandResult result =
      poise_command({"export", file_, "--gltf", folder_.file("a.glb"), "--pvd", folder_.file("vtk"), "--csv",
                     folder_.file("a.csv"), "--frames", "10..30", "--every", "5"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.out.find("jacks, 101 frames of 16.67 ms, 25 bodies"), std::string::npos) << result.out;
  EXPECT_EQ(contents(folder_.file("a.glb")).substr(0, 4), "glTF");
  const std::vector<std::string> rows = lines(contents(folder_.file("a.csv")));
  ASSERT_EQ(rows.size(), 6U);
  for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_EQ(cells(rows[i])[0], std::to_string(5 + 5 * i));
  for (const char* name : {"run.pvd", "frame-000010.vtp", "frame-000030.vtp", "shape-0.vtp", "shape-5.vtp"})
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "vtk" / name)) << name;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "vtk" / "frame-000011.vtp"));
}

TEST_F(Export, DrawsTheLastOfTheChosenFramesAndAllOfThemIntoAFolder) {
  const std::vector<std::string> small{"--picture-size", "96x64"};
  const auto drawn = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"export", file_, "--quiet"});
    arguments.insert(arguments.end(), small.begin(), small.end());
    const CommandResult result = poise_command(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.error;
  };
  drawn({"--frames", "20..40", "--every", "10", "--frames-dir", folder_.file("film"), "--picture",
         folder_.file("last.png")});
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "film"))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  EXPECT_EQ(names, (std::vector<std::string>{"frame-000020.png", "frame-000030.png", "frame-000040.png"}));
  const std::string last = contents(folder_.file("last.png"));
  EXPECT_EQ(last.substr(1, 3), "PNG");
  EXPECT_EQ(last, contents(folder_.file("film/frame-000040.png")));
  drawn({"--frame", "40", "--picture", folder_.file("same.png")});
  EXPECT_EQ(contents(folder_.file("same.png")), last);
  drawn({"--frame", "40", "--camera", "9,-9,6:0,0,1:40", "--picture", folder_.file("other.png")});
  EXPECT_NE(contents(folder_.file("other.png")), last);
}

TEST(Capture, OfARefusedRunOrReplayIsNotLeftBehind) {
  const TemporaryFolder folder;
  // Read as a scene, refused when its bodies are made.
  std::ofstream(folder.file("scene.json")) << R"({"name": "x", "dt_s": 0.01, "materials": {"m": {}},
    "shapes": {"none": {"mesh": {"file": "none.obj", "depth": 1}}}, "bodies": [{"shape": "none", "material": "m"}]})";
  const std::string file = folder.file("run.capture");
  EXPECT_EQ(poise_command({"run", folder.file("scene.json"), "--capture", file, "--quiet"}).exit_code, 3);
  EXPECT_FALSE(std::filesystem::exists(file));
  std::ofstream(file) << "an older one";
  EXPECT_EQ(poise_command({"run", folder.file("scene.json"), "--capture", file, "--quiet"}).exit_code, 3);
  EXPECT_EQ(contents(file), "an older one");
  const std::string record = folder.file("run.poise"), again = folder.file("again.capture");
  ASSERT_EQ(poise_command({"run", "two-body", "--frames", "3", "--record", record, "--quiet"}).exit_code, 0);
  const CommandResult refused =
      poise_command({"replay", record, "--capture", again, "--picture", folder.file("no/a.png")});
  EXPECT_EQ(refused.exit_code, 4) << refused.error;
  EXPECT_FALSE(std::filesystem::exists(again));
}

TEST_F(Export, OfARunThatWasKilledGoesUpToWhereItEndsAndSaysWhere) {
  const std::string bytes = contents(file_);
  std::ofstream(file_, std::ios::binary | std::ios::trunc) << bytes.substr(0, bytes.size() - 700);
  const CommandResult result = poise_command({"export", file_, "--csv", "-"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(lines(result.out).size(), 61U) << "one block of 60 frames";
  EXPECT_NE(result.error.find("poise export: warning: " + file_ + ": byte "), std::string::npos) << result.error;
  EXPECT_NE(result.error.find("the file ends within a chunk; the 60 frames before it are read"), std::string::npos);
}

TEST_F(Export, RefusesWrongOptionsAndFilesWithTheirRule) {
  EXPECT_EQ(refused({}), "2 poise export: one of --gltf, --pvd, --csv, --picture and --frames-dir is required\n");
  EXPECT_EQ(refused({"--csv", "-", "--frame", "1", "--frames", "1..2"}),
            "2 poise export: --frame and --frames cannot both be given\n");
  EXPECT_EQ(refused({"--csv", "-", "--frame", "1", "--every", "2"}),
            "2 poise export: --every has no meaning with --frame\n");
  for (const char* wrong : {"..", "5", "5..1", "a..b", "1...2", "-1..2", "1..99999999"}) {
    EXPECT_EQ(refused({"--csv", "-", std::string("--frames=") + wrong}),
              std::string("2 poise export: --frames = ") + wrong +
                  ", must be A..B, A.. or ..B with whole A <= B, at most 1000000\n");
  }
  EXPECT_EQ(refused({"--gltf", "-"}), "2 poise export: only --csv can go to the standard output\n");
  EXPECT_EQ(refused({"--gltf", "a.gltf"}),
            "2 poise export: --gltf a.gltf: a binary glTF is written, so the ending must be .glb\n");
  EXPECT_EQ(refused({"--picture", "a.jpg"}),
            "2 poise export: --picture a.jpg: a PNG is written, so the ending must be .png\n");
  EXPECT_EQ(refused({"--csv", "-", "--camera", "1,2,3:0,0,0"}), "2 poise export: --camera needs --picture\n");
  EXPECT_EQ(refused({"--frames-dir", "-"}), "2 poise export: only --json can go to the standard output\n");
  EXPECT_EQ(refused({"--picture", file_ + ".png", "--frame", "500"}),
            "3 poise export: " + file_ + ": has no frame from 500 up to 500\n");
  EXPECT_EQ(refused({"--picture", folder_.file("no/a.png")}).substr(0, 2), "4 ");
  EXPECT_EQ(refused({"--frames-dir", file_}).substr(0, 2), "4 ");
  EXPECT_EQ(refused({"--csv", file_}),
            "2 poise export: --csv " + file_ + ": would overwrite the file that is read as CAPTURE\n");
  EXPECT_EQ(refused({"--csv", "-", "--frame", "500"}),
            "3 poise export: " + file_ + ": has no frame from 500 up to 500\n");
  EXPECT_EQ(refused({"--csv", folder_.file("no/a.csv")}).substr(0, 2), "4 ");
  EXPECT_EQ(refused({"--pvd", file_}).substr(0, 2), "4 ");
  const CommandResult none = poise_command({"export", folder_.file("none"), "--csv", "-"});
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_EQ(none.error, "poise export: " + folder_.file("none") + ": no such file\n");
  const CommandResult other = poise_command({"export", "/dev/null", "--csv", "-"});
  EXPECT_EQ(other.exit_code, 3);
}

}  // namespace
}  // namespace poise::testing
