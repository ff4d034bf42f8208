// SPDX-License-Identifier: MIT
#include "studies/study_report.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "app/capture/run_capture.h"
#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/report/figures_page.h"
#include "assets/files/text_file.h"
#include "studies/child_command.h"

namespace poise::app {
namespace {

constexpr std::uint64_t kMostStudyBytes = std::uint64_t{64} << 20U;

bool has_gnuplot() {
  const parallel::Interrupt interrupt;
  const Result<ChildResult> version = run_program({"gnuplot", "--version"}, interrupt);
  return version && version.value().exit_code == 0;
}

/// Names the files that the options leave out. Those of an earlier run go, so that none is taken for one of this run.
void name_files(const std::string& folder, const StudyFiles& files) {
  const auto name = [&](std::string* path, const char* file) {
    if (path == nullptr || !path->empty()) return;
    *path = (std::filesystem::path(folder) / file).string();
    std::error_code ignored;
    std::filesystem::remove(*path, ignored);
  };
  name(files.json, "study.json");
  name(files.markdown, "study.md");
  if (files.picture == nullptr) return;
  if (files.picture_needs_gnuplot && !has_gnuplot()) {
    print_error("poise study: warning: the report has its charts, but no picture: that needs gnuplot-nox\n");
    return;
  }
  name(files.picture, "study.png");
  name(files.svg, "study.svg");
}

/// As it is typed: `poise study NAME ...`.
std::vector<std::string> study_command_line() {
  std::vector<std::string> words = command_line();
  if (words.empty()) return words;
  words[0] = "poise";
  words.insert(words.begin() + 1, "study");
  return words;
}

/// The settings that a study tells beside its rows.
std::vector<std::pair<std::string, std::string>> settings_of(const std::string& text) {
  std::vector<std::pair<std::string, std::string>> settings;
  const auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!json.is_object()) return settings;
  for (const auto& [name, value] : json.items()) {
    if (!value.is_primitive() || value.is_null() || name == "schema" || name == "command") continue;
    settings.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
  }
  return settings;
}

/// The closing line of the tables, which is taken from them; empty where they end with a table.
std::string take_closing_line(std::string& tables) {
  const std::size_t last = tables.find_last_not_of(" \n");
  if (last == std::string::npos) return "";
  const std::size_t begin = tables.rfind('\n', last) + 1;  // npos + 1 is 0
  if (tables[begin] == '|') return "";
  const std::string line = tables.substr(begin, last + 1 - begin);
  tables.resize(begin);
  return line;
}

int write_page(const StudyReport& report, const StudyFiles& files, int exit_code, FiguresFiles& page) {
  std::error_code failure;
  if (!std::filesystem::exists(*files.markdown, failure))
    return refuse("study " + report.study, kExitBadUsage, "--report: there are no figures to show");
  const Result<std::string> tables = geometry::read_text_file(*files.markdown, kMostStudyBytes);
  if (!tables) return refuse("study " + report.study, tables.error());
  const Result<std::string> json = geometry::read_text_file(*files.json, kMostStudyBytes);
  if (!json) return refuse("study " + report.study, json.error());
  FiguresDocument document;
  document.title = "study " + report.study;
  document.headline = report.description;
  document.tables = tables.value();
  document.headline_text = take_closing_line(document.tables);
  if (exit_code == kExitRequirementFailed) {
    document.mark = FiguresDocument::Mark::Bad;
    document.headline = "A figure is beyond its bound";
  }
  document.command = study_command_line();
  document.settings = settings_of(json.value());
  document.machine = io::this_machine();
  document.build = io::this_build();
  document.subtitle = document.machine.processor;
  document.charts = report.charts;
  for (const auto& [file, type] : {std::pair(files.svg, "image/svg+xml"), std::pair(files.picture, "image/png")}) {
    if (file == nullptr || !document.pictures.empty() || !std::filesystem::exists(*file, failure)) continue;
    const Result<std::string> picture = geometry::read_text_file(*file, kMostStudyBytes);
    if (!picture) return refuse("study " + report.study, picture.error());
    document.pictures.push_back({report.description, type, picture.value()});
  }
  Status written = page.write(document);
  if (written && (files.quiet == nullptr || !*files.quiet))
    written = io::write_stdout(fmt::format("report: {}\n", figures_page_of(report.folder)));
  return written ? exit_code : refuse("study " + report.study, written.error());
}

}  // namespace

void add_study_report(CLI::App& command, StudyReport& report) {
  add_path(command, "--report", report.folder,
           "Write a page into this folder that shows the study, and what it is made of (docs/viewing.md)");
}

int with_study_report(StudyReport& report, const StudyFiles& files, const std::function<int()>& study) {
  if (report.folder.empty()) return study();
  const std::string name = "study " + report.study;
  if (report.folder == "-") return refuse(name, kExitBadUsage, "--report must be a folder");
  const Status apart = check_outputs(
      {{"--json", *files.json}, {"--markdown", *files.markdown}, {"--report", figures_page_of(report.folder)}}, {});
  if (!apart) return refuse(name, kExitBadUsage, apart.error().message);
  if (*files.json == "-" || *files.markdown == "-") {
    return refuse(name, kExitBadUsage,
                  "--report shows what --json and --markdown write: neither can go to the standard output");
  }
  Result<FiguresFiles> page = FiguresFiles::open(report.folder);
  if (!page) return refuse(name, page.error());
  name_files(report.folder, files);
  const int exit_code = study();
  if (exit_code != kExitDone && exit_code != kExitRequirementFailed) return exit_code;
  return write_page(report, files, exit_code, page.value());
}

}  // namespace poise::app
