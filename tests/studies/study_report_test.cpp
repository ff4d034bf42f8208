// SPDX-License-Identifier: MIT
#include "studies/study_report.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/pages.h"
#include "app/process/exit_codes.h"
#include "app/report/figures_page.h"
#include "app/report/report_template.h"
#include "scene/temporary_folder.h"
#include "studies/gnuplot.h"

namespace poise::testing {
namespace {

using nlohmann::json;

bool figures_are_built() { return app::read_report_template(app::figures_template_places()).ok(); }

json figures_in(const std::string& page) { return json::parse(embedded(page, "poise-figures"), nullptr, false); }

struct Study {
  std::string json_path, markdown, picture, svg;
  int write(int exit_code) const {
    std::ofstream(json_path) << R"({"schema": "poise.x/1", "scene": "heap", "frames": 3, "rows": []})";
    std::ofstream(markdown) << "| a |\n|---|\n| 1 |\n\nwhat closes it; a machine\n";
    if (!svg.empty()) std::ofstream(svg) << "<svg/>";
    return exit_code;
  }
};

TEST(StudyReport, ShowsWhatTheStudyWroteWithItsClosingLineAsTheResult) {
  if (!figures_are_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  for (const int exit_code : {app::kExitDone, app::kExitRequirementFailed}) {
    Study study;
    study.svg = folder.file("mine.svg");
    const app::StudyFiles files{&study.json_path, &study.markdown, &study.picture, &study.svg};
    app::StudyReport report{
        "some", "What it is", folder.file("out"), {{"c", "chart", "", "x", {{"l", {{0, 1, {}, {}}}}}}}};
    EXPECT_EQ(app::with_study_report(report, files, [&] { return study.write(exit_code); }), exit_code);
    EXPECT_EQ(study.json_path, folder.file("out/study.json"));
    EXPECT_EQ(study.svg, folder.file("mine.svg")) << "what is named stays";
    const json figures = figures_in(contents(folder.file("out/report.html")));
    EXPECT_EQ(figures.at("title"), "study some");
    EXPECT_EQ(figures.at("tables"), "| a |\n|---|\n| 1 |\n\n");
    EXPECT_EQ(figures.at("headline").at("text"), "what closes it; a machine");
    EXPECT_EQ(figures.at("headline").at("mark"), exit_code == app::kExitDone ? "none" : "bad");
    EXPECT_EQ(figures.at("settings"), json::parse(R"({"scene": "heap", "frames": "3"})"));
    ASSERT_EQ(figures.at("charts").size(), 1U);
    EXPECT_TRUE(std::filesystem::exists(folder.file("out/c.png")));
    ASSERT_EQ(figures.at("pictures").size(), 1U);
    EXPECT_EQ(figures.at("pictures")[0].at("type"), "image/svg+xml");
  }
}

TEST(StudyReport, IsNoneWhereTheStudyFailsOrShowsNothing) {
  if (!figures_are_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  Study study;
  const app::StudyFiles files{&study.json_path, &study.markdown};
  app::StudyReport report{"some", "What it is", folder.file("out")};
  EXPECT_EQ(app::with_study_report(report, files, [&] { return study.write(app::kExitBadInput); }), app::kExitBadInput);
  EXPECT_FALSE(std::filesystem::exists(folder.file("out/report.html")));
  // What the run before has left is not taken for figures of this one.
  study = {};
  EXPECT_EQ(app::with_study_report(report, files, [] { return app::kExitDone; }), app::kExitBadUsage);
  EXPECT_FALSE(std::filesystem::exists(folder.file("out/report.html")));
}

TEST(StudyReport, WithoutAFolderTheStudyAloneRuns) {
  const TemporaryFolder folder;
  Study study;
  const app::StudyFiles files{&study.json_path, &study.markdown};
  app::StudyReport report{"some", "What it is", ""};
  EXPECT_EQ(app::with_study_report(report, files, [] { return 7; }), 7);
  EXPECT_EQ(study.json_path, "");
}

TEST(StudyReport, IsAnOptionOfEveryStudy) {
  for (const char* name : {"accuracy", "cache", "compliance", "constant-time", "cost", "forecast", "free", "gaze",
                           "levels", "order", "overload", "population", "scaling", "strips", "trees"}) {
    const CommandResult help = poise_command({"study", name, "--help"});
    EXPECT_NE(help.out.find("--report"), std::string::npos) << name;
  }
}

/// A search path without any program, while it lives.
class NoPrograms {
 public:
  explicit NoPrograms(const std::string& folder) { ::setenv("PATH", folder.c_str(), 1); }
  ~NoPrograms() { ::setenv("PATH", before_.c_str(), 1); }
  NoPrograms(const NoPrograms&) = delete;
  NoPrograms& operator=(const NoPrograms&) = delete;

 private:
  std::string before_ = ::getenv("PATH") == nullptr ? "" : ::getenv("PATH");
};

TEST(StudyReport, OfEveryStudyShowsAChartOrAPictureWithoutGnuplot) {
  if (!figures_are_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  const std::vector<std::vector<std::string>> studies{
      {"accuracy", "--only", "slope, box on plane"},
      {"cache", "--bodies", "30", "--frames", "2", "--settle", "5"},
      {"compliance", "--bodies", "20", "--frames", "10", "--warmup", "2", "--populations", "1"},
      {"constant-time", "--most-bodies", "100", "--frames", "5", "--warmup", "2"},
      {"cost", "--bodies", "30", "--frames", "2", "--skip", "1", "--settle", "4"},
      {"forecast", "--bodies", "60", "--frames", "40", "--warmup", "30"},
      {"gaze", "--bodies", "60", "--settle", "20", "--seeds", "1", "--states", "1", "--jumps", "1"},
      {"order", "--bodies", "60", "--frames", "4", "--warmup", "30", "--budget", "20"},
      {"overload", "--bodies", "30", "--settle", "20", "--hold", "10", "--clock", "work", "--drive", "deadline"},
      {"population", "--bodies", "30,60", "--frames", "5"},
      {"scaling", "--bodies", "60", "--frames", "2", "--settle", "40"},
      {"scaling", "--span", "--bodies", "30", "--frames", "2", "--settle", "5"},
      {"strips"},
      {"trees", std::string(POISE_MESHES) + "/l.obj", "--depth", "1", "--samples", "100", "--preset", "fast"},
  };
  const NoPrograms nothing(folder.file("none"));
  for (const std::vector<std::string>& study : studies) {
    std::vector<std::string> arguments{"study"};
    arguments.insert(arguments.end(), study.begin(), study.end());
    arguments.insert(arguments.end(), {"--quiet", "--report", folder.file(study[0])});
    const CommandResult result = poise_command(arguments);
    // A deadline that was missed on a busy machine is a finding, not a failure.
    ASSERT_LE(result.exit_code, app::kExitRequirementFailed) << study[0] << ": " << result.error;
    const json figures = figures_in(contents(folder.file(study[0] + "/report.html")));
    ASSERT_TRUE(figures.is_object()) << study[0];
    EXPECT_GE(figures.at("charts").size() + figures.at("pictures").size(), 1U) << study[0];
    for (const json& chart : figures.at("charts")) {
      EXPECT_FALSE(chart.at("lines").empty()) << study[0];
      EXPECT_TRUE(std::filesystem::exists(folder.file(study[0] + "/" + chart.at("id").get<std::string>() + ".svg")));
    }
  }
}

TEST(StudyReport, IsRefusedByOptionAndRule) {
  struct Refusal {
    std::vector<std::string> arguments;
    std::string message;
  };
  const TemporaryFolder folder;
  const std::string out = folder.file("r");
  const std::vector<Refusal> refusals{
      {{"--report", "-"}, "poise study accuracy: --report must be a folder"},
      {{"--report", out, "--json", out + "/report.html"}, "is named for two outputs: --json and --report"},
      {{"--report", out, "--json", "-"}, "neither can go to the standard output"},
      {{"--svg", "-"}, "--svg must be a file"},
  };
  for (const Refusal& refusal : refusals) {
    std::vector<std::string> arguments{"study", "accuracy", "--only", "slope"};
    arguments.insert(arguments.end(), refusal.arguments.begin(), refusal.arguments.end());
    const CommandResult result = poise_command(arguments);
    EXPECT_EQ(result.exit_code, 2) << refusal.message;
    EXPECT_NE(result.error.find(refusal.message), std::string::npos) << result.error;
  }
  if (figures_are_built()) return;
  const CommandResult missing = poise_command({"study", "accuracy", "--only", "slope", "--report", out});
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_NE(missing.error.find("--report: the page for reports is not built"), std::string::npos) << missing.error;
}

TEST(StudyPicture, ThePngScriptBecomesOneForSvg) {
  EXPECT_EQ(app::svg_script("set terminal pngcairo size 900,560 font \"sans,13\" background rgb \"#fafafb\"\nplot 1\n"),
            "set terminal svg size 900,560 font \"sans,13\" background rgb \"#fafafb\"\nplot 1\n");
}

TEST(StudyPicture, TheSvgOfGnuplotIsDarkWhereABrowserPrefersThat) {
  const std::string svg = app::svg_of_gnuplot(
      "<svg \n width=\"9\"\n>\n<path stroke='rgb(  0, 114, 178)'/><g fill=\"rgb(26,32,39)\" d='M1'/><path "
      "stroke='black' color='rgb(  0, 114, 178)'/></svg>");
  EXPECT_NE(svg.find(">\n<style>@media (prefers-color-scheme: dark)"), std::string::npos) << svg;
  EXPECT_NE(svg.find("<path stroke=\"#0072b2\"/><g fill=\"#1a2027\" d='M1'/><path stroke='black' "
                     "color=\"#0072b2\"/></svg>"),
            std::string::npos)
      << svg;
}

}  // namespace
}  // namespace poise::testing
