// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "app/report/line_chart.h"
#include "poise/result.h"
#include "scene/made_by.h"
#include "scene/result_file.h"

namespace poise::app {

/// A picture that another program drew.
struct DrawnPicture {
  std::string title;
  std::string type;  ///< `image/svg+xml` or `image/png`
  std::string bytes;
};

/// What a page of figures says. Texts are shown as text, never as markup.
struct FiguresDocument {
  enum class Mark { None, Good, Bad };
  std::string title, subtitle;
  Mark mark = Mark::None;
  std::string headline, headline_text;  ///< what came out, and a sentence
  std::vector<LineChart> charts;
  std::vector<DrawnPicture> pictures;
  std::string tables;                                         ///< tables and paragraphs, as they are written for docs
  std::vector<std::string> command;                           ///< words of the command line
  std::vector<std::pair<std::string, std::string>> settings;  ///< names and values
  io::Machine machine;
  io::BuildFacts build;
};

/// Where the built page of figures may lie: beside the page of a run (report_template_places).
std::vector<std::filesystem::path> figures_template_places();

/// The template with the document in the place of its data.
std::string figures_page(const std::string& page, const FiguresDocument& document);

/// The page in this folder; an empty name for an empty one.
std::string figures_page_of(const std::string& folder);

/// What `--report FOLDER` of a comparison or a study writes: `report.html`, and each chart as SVG and PNG.
class FiguresFiles {
 public:
  /// Makes the folder and tries the page, before the work. Refused: a page that is not built, what cannot be written.
  static Result<FiguresFiles> open(const std::string& folder);
  Status write(const FiguresDocument& document);

 private:
  FiguresFiles(std::filesystem::path folder, std::string page, io::AtomicFile html)
      : folder_(std::move(folder)), page_(std::move(page)), html_(std::move(html)) {}
  std::filesystem::path folder_;
  std::string page_;
  io::AtomicFile html_;
};

}  // namespace poise::app
