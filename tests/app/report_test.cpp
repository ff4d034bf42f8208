// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/report/frame_chart.h"
#include "app/report/report_page.h"
#include "app/report/report_template.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

void write(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

/// What stands in the script element with this id; empty where there is none.
std::string embedded(const std::string& page, const std::string& id) {
  const std::size_t at = page.find(" id=\"" + id + "\">");
  if (at == std::string::npos) return "";
  const std::size_t begin = page.find('>', at) + 1;
  return page.substr(begin, page.find("</script>", begin) - begin);
}

std::string base64(const std::string& bytes) {
  std::string text;
  app::append_base64(bytes, text);
  return text;
}

bool page_is_built() { return app::read_report_template().ok(); }

simulation::RunFrame frame_of(double total_ms, MissCause cause = MissCause::None) {
  simulation::RunFrame frame;
  const auto time = Nanoseconds(static_cast<std::int64_t>(total_ms * 1e6));
  frame.report.times.solve = time;
  frame.report.times.total = time;
  frame.report.cause = cause;
  return frame;
}

TEST(Base64, HasTheValuesOfItsStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string("\xff\xfe\0", 3)), "//4A");
}

TEST(ShellLine, IsReadAsTheSameWords) {
  EXPECT_EQ(app::shell_line({"poise", "run", "pile", "--report", "out/pile"}), "poise run pile --report out/pile");
  EXPECT_EQ(app::shell_line({"--require", "miss_rate < 0.01", "it's", ""}),
            "--require 'miss_rate < 0.01' 'it'\\''s' ''");
}

TEST(ReportTemplate, IsTheFirstThatIsThere) {
  const TemporaryFolder folder;
  write(folder.file("b"), "b <!-- poise:data --> b");
  write(folder.file("c"), "c <!-- poise:data --> c");
  const auto found = app::read_report_template({folder.file("a"), folder.file("b"), folder.file("c")});
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found.value().front(), 'b');
}

TEST(ReportTemplate, IsRefusedWhereItIsNotBuiltOrNoPage) {
  const TemporaryFolder folder;
  const auto missing = app::read_report_template({folder.file("a"), folder.file("b")});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().message,
            "the page for reports is not built (looked for " + folder.file("a") + ", " + folder.file("b") +
                "): cmake/build_viewer.sh in the source builds it, with node 18 or later and npm");
  write(folder.file("a"), "<html>");
  const auto other = app::read_report_template({folder.file("a")});
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().message,
            folder.file("a") + ": no page for reports: the line <!-- poise:data --> is not in it");
}

TEST(ReportPage, HoldsItsPartsWhereTheTemplateSaysAndNoMarkupOfTheRun) {
  const TemporaryFolder folder;
  const std::string capture = folder.file("run.capture");
  // Longer than a block in which it is read, and no multiple of three.
  const std::string bytes = "poise.capture/1\n" + std::string((std::size_t{3} << 18U) + 1, 'x');
  write(capture, bytes);
  auto file = io::AtomicFile::open(folder.file("page.html"));
  ASSERT_TRUE(file.ok());
  const app::ReportParts parts{
      {"poise", "run", "</script>"}, R"({"scene": "</script><b>"})", "frame,cause\n0,none\n", {capture, capture}};
  ASSERT_TRUE(app::write_report_page("before <!-- poise:data --> after $&", parts, file.value()).ok());
  ASSERT_TRUE(file.value().commit().ok());
  const std::string page = contents(folder.file("page.html"));
  EXPECT_EQ(page.substr(0, 7), "before ");
  EXPECT_EQ(page.substr(page.size() - 9), " after $&");
  EXPECT_EQ(json::parse(embedded(page, "poise-run")).at("scene"), "</script><b>");
  const json about = json::parse(embedded(page, "poise-page"));
  EXPECT_EQ(about.at("command"), "poise run '</script>'");
  EXPECT_EQ(about.at("captures"), json::parse(R"(["run.capture", "run.capture"])"));
  EXPECT_EQ(embedded(page, "poise-frames"), "frame,cause\n0,none\n");
  EXPECT_EQ(embedded(page, "poise-capture"), base64(bytes));
  EXPECT_EQ(embedded(page, "poise-capture-b"), base64(bytes));
}

TEST(ReportPage, RefusesCapturesThatNoPageCanShow) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& path) { return app::check_capture_file(path).error().message; };
  EXPECT_EQ(message(folder.file("none")), folder.file("none") + ": No such file or directory");
  const std::string file = folder.file("x");
  for (const char* text : {"", "poise.record/5\n", "poise.capture/2\n and more"}) {
    write(file, text);
    EXPECT_EQ(message(file), file + ": not a capture of this version (poise.capture/1)") << text;
  }
  write(file, "poise.capture/1\n");
  EXPECT_TRUE(app::check_capture_file(file).ok());
  std::filesystem::resize_file(file, app::kMostCaptureBytes);
  EXPECT_TRUE(app::check_capture_file(file).ok());
  std::filesystem::resize_file(file, app::kMostCaptureBytes + 1);
  EXPECT_EQ(message(file), file +
                               ": 268435457 bytes, must be at most 268435456 for a page: capture fewer frames or "
                               "bodies, or with a larger --capture-step");
}

TEST(FrameChart, StacksTimesToTheirScaleAndMarksLateFrames) {
  const std::vector<simulation::RunFrame> frames{frame_of(4), frame_of(8, MissCause::Forecast), frame_of(2)};
  const app::FrameChart chart = app::frame_chart("<heap>", 5.0, frames);
  constexpr std::array<std::uint8_t, 3> kSolve{0xe6, 0x9f, 0x00}, kForecast{0x00, 0x72, 0xb2};
  std::vector<app::ChartBox> columns, marks;
  for (const app::ChartBox& box : chart.boxes) {
    if (box.color == kSolve && box.width > 100) columns.push_back(box);
    if (box.color == kForecast && box.width == 8) marks.push_back(box);
  }
  ASSERT_EQ(columns.size(), 3U);
  EXPECT_NEAR(columns[1].height, 2 * columns[0].height, 1e-6);
  EXPECT_NEAR(columns[1].height, 4 * columns[2].height, 1e-6);
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_NEAR(marks[0].left + 4, columns[1].left + columns[1].width / 2, 1e-6) << "above its frame";
  EXPECT_LT(marks[0].top + 8, columns[1].top);
  const std::string svg = app::frame_chart_svg(chart);
  EXPECT_NE(svg.find("&lt;heap>: 3 frames, deadline 5 ms"), std::string::npos);
  EXPECT_NE(svg.find("late, forecast: 1"), std::string::npos);
  const io::Image image = app::frame_chart_image(chart);
  const auto pixel = [&](double x, double y) {
    const std::size_t at = 3 * (static_cast<std::size_t>(y) * image.width_px + static_cast<std::size_t>(x));
    return std::array<std::uint8_t, 3>{image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
  };
  EXPECT_EQ(pixel(columns[1].left + 20, columns[1].top + 4), kSolve);
  EXPECT_NE(pixel(columns[1].left + 20, columns[1].top - 4), kSolve);
  EXPECT_EQ(pixel(marks[0].left + 4, marks[0].top + 4), kForecast);
}

TEST(FrameChart, ShowsTheSlowestOfManyFramesAndIsMadeOfNone) {
  std::vector<simulation::RunFrame> frames(100'000, frame_of(1));
  frames[77'777] = frame_of(1.5);
  const app::FrameChart chart = app::frame_chart("pile", std::nullopt, frames);
  EXPECT_LT(chart.boxes.size(), 3000U);
  const auto tallest = std::max_element(chart.boxes.begin() + 1, chart.boxes.end(),
                                        [](const auto& a, const auto& b) { return a.height < b.height; });
  EXPECT_NEAR(tallest->left, 80 + 1100 * 0.77777, 2);
  EXPECT_FALSE(app::frame_chart_svg(app::frame_chart("pile", 4.0, {})).empty());
}

TEST(RunReport, IsWrittenWholeOrRefusedBeforeTheRun) {
  const TemporaryFolder folder;
  const std::string out = folder.file("made/here");
  const CommandResult result =
      poise_command({"run", "two-body", "--frames", "20", "--deadline", "8", "--report", out, "--quiet"});
  if (!page_is_built()) {
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(result.error.find("--report: the page for reports is not built (looked for "), std::string::npos)
        << result.error;
    EXPECT_FALSE(std::filesystem::exists(out));
    return;
  }
  ASSERT_EQ(result.exit_code, 0) << result.error;
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(out)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"frame-times.png", "frame-times.svg", "report.html", "run.capture"}));
  const std::string page = contents(out + "/report.html");
  EXPECT_EQ(json::parse(embedded(page, "poise-run")).at("scene"), "two-body");
  const std::string frames = embedded(page, "poise-frames");
  EXPECT_EQ(std::count(frames.begin(), frames.end(), '\n'), 21);
  EXPECT_EQ(embedded(page, "poise-capture"), base64(contents(out + "/run.capture")));
  EXPECT_EQ(json::parse(embedded(page, "poise-page")).at("command"),
            "poise run two-body --frames 20 --deadline 8 --report " + out + " --quiet");
}

TEST(RunReport, LeavesTheRunAsItWas) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  const auto hash = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"run",     "jacks", "--bodies", "30", "--frames", "10",
                                       "--clock", "work",  "--json",   "-",  "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json::parse(poise_command(arguments).out, nullptr, false).at("state_hash");
  };
  EXPECT_EQ(hash({}), hash({"--report", folder.file("r"), "--capture", folder.file("c"), "--capture-contacts"}));
  EXPECT_FALSE(std::filesystem::exists(folder.file("r") + "/run.capture")) << "the capture has a name of its own";
  EXPECT_TRUE(std::filesystem::exists(folder.file("c")));
}

TEST(RunReport, IsRefusedWhereItCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_EQ(poise_command({"run", "two-body", "--report", "-"}).exit_code, 2);
  const CommandResult twice =
      poise_command({"run", "two-body", "--report", folder.file("r"), "--json", folder.file("r/report.html")});
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_NE(twice.error.find("report.html is named for two outputs: --json and --report"), std::string::npos)
      << twice.error;
  if (!page_is_built()) return;
  write(folder.file("file"), "x");
  EXPECT_EQ(poise_command({"run", "two-body", "--frames", "1", "--report", folder.file("file/r")}).exit_code, 4);
}

TEST(View, MakesThePageOfACaptureBesideIt) {
  const TemporaryFolder folder;
  const std::string capture = folder.file("two.capture");
  ASSERT_EQ(poise_command({"run", "two-body", "--frames", "5", "--capture", capture, "--quiet"}).exit_code, 0);
  const CommandResult made = poise_command({"view", capture});
  if (!page_is_built()) {
    EXPECT_EQ(made.exit_code, 3);
    EXPECT_NE(made.error.find("poise view: the page for reports is not built"), std::string::npos) << made.error;
    return;
  }
  ASSERT_EQ(made.exit_code, 0) << made.error;
  EXPECT_EQ(made.out, folder.file("two.html") + "\n");
  EXPECT_EQ(embedded(contents(folder.file("two.html")), "poise-capture"), base64(contents(capture)));
  const CommandResult both = poise_command({"view", capture, capture, "--out", folder.file("both.html")});
  ASSERT_EQ(both.exit_code, 0) << both.error;
  EXPECT_EQ(embedded(contents(folder.file("both.html")), "poise-capture-b"), base64(contents(capture)));
}

TEST(View, IsRefusedByFileAndRule) {
  const TemporaryFolder folder;
  const std::string file = folder.file("a.capture");
  write(file, "poise.capture/1\n");
  EXPECT_EQ(poise_command({"view"}).exit_code, 2);
  EXPECT_EQ(poise_command({"view", file, "--out", "-"}).exit_code, 2);
  const CommandResult over = poise_command({"view", file, "--out", file});
  EXPECT_EQ(over.exit_code, 2);
  EXPECT_NE(over.error.find("would overwrite the file that is read as CAPTURE"), std::string::npos) << over.error;
  const CommandResult missing = poise_command({"view", folder.file("none")});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_NE(missing.error.find("none: No such file or directory"), std::string::npos) << missing.error;
  write(file, "something else entirely");
  const CommandResult other = poise_command({"view", file});
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_NE(other.error.find("not a capture of this version"), std::string::npos) << other.error;
}

}  // namespace
}  // namespace poise::testing
