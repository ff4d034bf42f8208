// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/pages.h"
#include "app/report/report_page.h"
#include "app/report/report_template.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

void write(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

std::string base64(const std::string& bytes) {
  std::string text;
  app::append_base64(bytes, text);
  return text;
}

bool page_is_built() { return app::read_report_template().ok(); }

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
  EXPECT_EQ(message(folder.file("none")), folder.file("none") + ": no such file");
  const std::string file = folder.file("x");
  for (const char* text : {"", "poise.record/6\n", "poise.capture/2\n and more"}) {
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

TEST(RunReport, IsWrittenWholeOrRefusedBeforeTheRun) {
  const TemporaryFolder folder;
  const std::string out = folder.file("made/here");
  const CommandResult result =
      poise_command({"run", "two-body", "--frames", "90", "--deadline", "8", "--report", out, "--quiet"});
  if (!page_is_built()) return expect_no_page(result, out);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(files_in(out),
            (std::vector<std::string>{"frame-times.png", "frame-times.svg", "levels.png", "levels.svg",
                                      "percentiles.png", "percentiles.svg", "report.html", "run.capture"}));
  const std::string page = contents(out + "/report.html");
  EXPECT_EQ(json::parse(embedded(page, "poise-run")).at("scene"), "two-body");
  const std::string frames = embedded(page, "poise-frames");
  EXPECT_EQ(std::count(frames.begin(), frames.end(), '\n'), 91);
  EXPECT_EQ(embedded(page, "poise-capture"), base64(contents(out + "/run.capture")));
  EXPECT_EQ(json::parse(embedded(page, "poise-page")).at("command"),
            "poise run two-body --frames 90 --deadline 8 --report " + out + " --quiet");
}

TEST(RunReport, WithoutContactsHasNoChartOfThemNorThatOfAnEarlierRun) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  const std::string out = folder.file("r");
  std::filesystem::create_directory(out);
  for (const char* name : {"levels.svg", "levels.png", "mine.svg"}) write(out + "/" + name, "of before");
  const CommandResult result =
      poise_command({"run", "two-body", "--frames", "1", "--deadline", "8", "--report", out, "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(files_in(out),
            (std::vector<std::string>{"frame-times.png", "frame-times.svg", "mine.svg", "percentiles.png",
                                      "percentiles.svg", "report.html", "run.capture"}));
}

TEST(RunReport, IsNamedBelowTheTable) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  const std::string out = folder.file("r");
  const CommandResult result = poise_command({"run", "two-body", "--frames", "1", "--report", out});
  EXPECT_TRUE(result.out.ends_with("report         " + out + "/report.html\n")) << result.out;
  const CommandResult refused = poise_command({"run", "two-body", "--frames", "1", "--report", "/proc/none"});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_NE(refused.error.find("--report: /proc/none: cannot be made: "), std::string::npos) << refused.error;
}

TEST(View, TellsTwoCapturesOfOneNameApartByTheirFolders) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  for (const char* name : {"a", "b"}) {
    const std::string out = folder.file(name);
    ASSERT_EQ(poise_command({"run", "two-body", "--frames", "2", "--report", out, "--quiet"}).exit_code, 0);
  }
  const std::string page = folder.file("both.html");
  const CommandResult both =
      poise_command({"view", folder.file("a/run.capture"), folder.file("b/run.capture"), "--out", page});
  ASSERT_EQ(both.exit_code, 0) << both.error;
  EXPECT_EQ(json::parse(embedded(contents(page), "poise-page")).at("captures"),
            json::parse(R"(["a/run.capture", "b/run.capture"])"));
}

TEST(RunReport, LeavesTheRunAsItWas) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  EXPECT_EQ(hash_of_jacks(),
            hash_of_jacks({"--report", folder.file("r"), "--capture", folder.file("c"), "--capture-contacts"}));
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

TEST(View, RefusesACaptureWithoutFrames) {
  const TemporaryFolder folder;
  const std::string capture = folder.file("two.capture"), file = folder.file("a.capture");
  ASSERT_EQ(poise_command({"run", "two-body", "--frames", "5", "--capture", capture, "--quiet"}).exit_code, 0);
  const std::string whole = contents(capture);
  // As a run leaves it that is killed in its first frames: header, shapes and bodies.
  write(file, whole.substr(0, whole.find("FRAM")));
  for (const std::vector<std::string>& captures : {std::vector{file}, {file, capture}, {capture, file}}) {
    std::vector<std::string> words{"view", "--out", folder.file("a.html")};
    words.insert(words.end(), captures.begin(), captures.end());
    const CommandResult refused = poise_command(words);
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_NE(refused.error.find("a.capture: has no frames"), std::string::npos) << refused.error;
    EXPECT_FALSE(std::filesystem::exists(folder.file("a.html"))) << "a page of nothing";
  }
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
  const CommandResult headless = poise_command({"view", file});
  EXPECT_EQ(headless.exit_code, 3);
  EXPECT_NE(headless.error.find("a.capture: "), std::string::npos) << headless.error;
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.html"))) << "a page of nothing";
  const CommandResult page = poise_command({"view", folder.file("out/report.html")});
  EXPECT_EQ(page.exit_code, 2);
  EXPECT_NE(page.error.find("report.html: is a page, which a browser opens; view takes captures"), std::string::npos);
  const CommandResult missing = poise_command({"view", folder.file("none")});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_NE(missing.error.find("none: no such file"), std::string::npos) << missing.error;
  write(file, "something else entirely");
  const CommandResult other = poise_command({"view", file});
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_NE(other.error.find("not a capture of this version"), std::string::npos) << other.error;
}

}  // namespace
}  // namespace poise::testing
