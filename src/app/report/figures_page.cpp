// SPDX-License-Identifier: MIT
#include "app/report/figures_page.h"

#include <nlohmann/json.hpp>

#include "app/files/output_files.h"
#include "app/process/refusal.h"
#include "app/report/chart_axes.h"
#include "app/report/report_page.h"
#include "app/report/report_template.h"

namespace poise::app {
namespace {

using Json = nlohmann::ordered_json;

const char* mark_name(FiguresDocument::Mark mark) {
  switch (mark) {
    case FiguresDocument::Mark::None:
      return "none";
    case FiguresDocument::Mark::Good:
      return "good";
    case FiguresDocument::Mark::Bad:
      return "bad";
  }
  return "none";
}

// A tick is [value, text].
Json json_of(const ChartAxis& axis) {
  Json ticks = Json::array();
  for (const ChartTick& tick : axis.ticks) ticks.push_back(Json::array({tick.at, tick.text}));
  return {{"least", axis.least}, {"most", axis.most}, {"log", axis.log}, {"ticks", ticks}};
}

const char* name_of(LineMarks marks) {
  switch (marks) {
    case LineMarks::LineAndDots:
      return "both";
    case LineMarks::Line:
      return "line";
    case LineMarks::Dots:
      return "dots";
  }
  return "both";
}

// A point is [x, y] or [x, y, low, high]; y is null in a gap.
Json json_of(const LineChart& chart) {
  Json json{{"id", chart.id}, {"title", chart.title}, {"note", chart.note}, {"x_label", chart.x_label}};
  const ChartAxis y = y_axis_of(chart);
  json["x"] = json_of(x_axis_of(chart));
  json["y"] = json_of(y);
  json["levels"] = Json::array();
  for (const ChartLevel& level : chart.levels)
    json["levels"].push_back(
        {{"label", level.label}, {"y", level.y}, {"line", level.line ? Json(*level.line) : Json()}});
  json["lines"] = Json::array();
  for (const ChartLine& line : chart.lines) {
    Json points = Json::array();
    for (const LinePoint& point : line.points) {
      Json& numbers = points.emplace_back(Json::array({point.x, y.shows(point.y) ? Json(point.y) : Json()}));
      // A band that the axis cannot show would be no polygon.
      if (point.low && point.high && y.shows(*point.low) && y.shows(*point.high))
        numbers.insert(numbers.end(), {*point.low, *point.high});
    }
    json["lines"].push_back({{"label", line.label}, {"marks", name_of(line.marks)}, {"points", points}});
  }
  return json;
}

}  // namespace

std::vector<std::filesystem::path> figures_template_places() {
  std::vector<std::filesystem::path> places = report_template_places();
  for (std::filesystem::path& place : places) place.replace_filename("figures.html");
  return places;
}

std::string figures_page(const std::string& page, const FiguresDocument& document) {
  Json json{{"title", document.title}, {"subtitle", document.subtitle}};
  json["headline"] = {
      {"mark", mark_name(document.mark)}, {"title", document.headline}, {"text", document.headline_text}};
  json["charts"] = Json::array();
  for (const LineChart& chart : document.charts) json["charts"].push_back(json_of(chart));
  json["pictures"] = Json::array();
  for (const DrawnPicture& picture : document.pictures) {
    std::string base64;
    append_base64(picture.bytes, base64);
    json["pictures"].push_back({{"title", picture.title}, {"type", picture.type}, {"base64", base64}});
  }
  json["tables"] = document.tables;
  json["command"] = shell_line(document.command);
  json["settings"] = Json::object();
  for (const auto& [name, value] : document.settings) json["settings"][name] = value;
  json["machine"] = document.machine;
  json["build"] = document.build;
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::size_t place = page.find(kReportData);
  return page.substr(0, place) + data_element("poise-figures", "application/json", text) +
         page.substr(place + kReportData.size());
}

std::string figures_page_of(const std::string& folder) {
  return folder.empty() ? std::string() : (std::filesystem::path(folder) / "report.html").string();
}

Result<FiguresFiles> FiguresFiles::open(const std::string& folder) {
  Result<std::string> page = read_report_template(figures_template_places());
  if (!page) return bad_input("--report: " + page.error().message);
  const Status there = make_folder("--report", folder);
  if (!there) return there.error();
  Result<io::AtomicFile> html = io::AtomicFile::open(figures_page_of(folder));
  if (!html) return html.error();
  return FiguresFiles(folder, std::move(page).value(), std::move(html).value());
}

Status FiguresFiles::write(const FiguresDocument& document) {
  Status written = html_.write(figures_page(page_, document));
  if (written) written = html_.commit();
  for (const LineChart& chart : document.charts) {
    const std::string name = (folder_ / chart.id).string();
    add_failure(io::write_file(name + ".svg", line_chart_svg(chart)), written);
    const Result<std::string> png = io::png_bytes(line_chart_image(chart));
    add_failure(png ? io::write_file(name + ".png", png.value()) : Status(png.error()), written);
  }
  return written;
}

}  // namespace poise::app
