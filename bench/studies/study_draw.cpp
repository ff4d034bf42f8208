// SPDX-License-Identifier: MIT
#include "studies/study_draw.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "assets/files/text_file.h"
#include "scene/result_file.h"
#include "studies/study_charts.h"

namespace poise::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kMostBytes = std::uint64_t{64} << 20U;
constexpr std::size_t kMostColumns = 4;
constexpr std::array kMarks{"both", "line", "dots"};  // in the order of LineMarks
constexpr std::pair<const char*, std::string LineChart::*> kTexts[] = {
    {"id", &LineChart::id}, {"title", &LineChart::title}, {"note", &LineChart::note}, {"x_label", &LineChart::x_label}};
constexpr std::pair<const char*, bool LineChart::*> kFlags[] = {{"x_log", &LineChart::x_log},
                                                                {"y_log", &LineChart::y_log},
                                                                {"x_measured", &LineChart::x_measured},
                                                                {"y_from_data", &LineChart::y_from_data}};

// Nothing for what is no number, as JSON has none for it.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }
double number(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json json_of(const ChartLine& line) {
  Json points = Json::array();
  for (const LinePoint& point : line.points) {
    Json& made = points.emplace_back(Json::array({number(point.x), number(point.y)}));
    if (!point.low || !point.high) continue;
    made.push_back(number(*point.low));
    made.push_back(number(*point.high));
  }
  return {{"label", line.label}, {"marks", kMarks[static_cast<std::size_t>(line.marks)]}, {"points", points}};
}

Json json_of(const LineChart& chart) {
  Json json = Json::object();
  for (const auto& [name, text] : kTexts) json[name] = chart.*text;
  for (const auto& [name, flag] : kFlags) json[name] = chart.*flag;
  json["x_names"] = chart.x_names;
  json["levels"] = Json::array();
  for (const ChartLevel& level : chart.levels) {
    json["levels"].push_back(
        {{"label", level.label}, {"y", number(level.y)}, {"line", level.line ? Json(*level.line) : Json()}});
  }
  json["lines"] = Json::array();
  for (const ChartLine& line : chart.lines) json["lines"].push_back(json_of(line));
  return json;
}

// These throw what nlohmann::json throws where a member is missing or of another type.
ChartLine line_of(const Json& json) {
  ChartLine line{json.at("label"), {}};
  for (std::size_t k = 0; k < kMarks.size(); ++k) {
    if (json.at("marks") == kMarks[k]) line.marks = static_cast<LineMarks>(k);
  }
  for (const Json& point : json.at("points")) {
    LinePoint& made = line.points.emplace_back(LinePoint{number(point.at(0)), number(point.at(1)), {}, {}});
    if (point.size() < 4) continue;
    made.low = number(point.at(2));
    made.high = number(point.at(3));
  }
  return line;
}

LineChart chart_of(const Json& json) {
  LineChart chart;
  for (const auto& [name, text] : kTexts) chart.*text = json.at(name);
  for (const auto& [name, flag] : kFlags) chart.*flag = json.at(name);
  chart.x_names = json.at("x_names").get<std::vector<std::string>>();
  for (const Json& line : json.at("lines")) chart.lines.push_back(line_of(line));
  for (const Json& level : json.at("levels")) {
    ChartLevel& made = chart.levels.emplace_back(ChartLevel{level.at("label"), number(level.at("y")), {}});
    if (level.at("line").is_null()) continue;
    made.line = level.at("line").get<std::size_t>();
    if (*made.line >= chart.lines.size()) throw std::out_of_range("a level of no line");
  }
  return chart;
}

}  // namespace

std::string with_charts(const std::string& json, const std::vector<LineChart>& charts, std::size_t columns) {
  Json document = Json::parse(json, nullptr, false);
  if (!document.is_object() || charts.empty()) return json;
  Json made = Json::array();
  for (const LineChart& chart : charts) made.push_back(json_of(chart));
  document["drawing"] = {{"columns", columns}, {"charts", std::move(made)}};
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<StudyDrawing> drawing_of(const std::string& json, const std::string& name) {
  const Json document = Json::parse(json, nullptr, false);
  if (!document.is_object() || !document.contains("drawing"))
    return bad_input(name + ": has no drawing, as --json of a study writes it; strips have none");
  StudyDrawing drawing;
  try {
    const Json& member = document.at("drawing");
    drawing.columns = member.at("columns");
    for (const Json& chart : member.at("charts")) drawing.charts.push_back(chart_of(chart));
  } catch (const std::exception& wrong) {
    return bad_input(fmt::format("{}: drawing: {}", name, wrong.what()));
  }
  if (drawing.columns < 1 || drawing.columns > kMostColumns)
    return bad_input(fmt::format("{}: drawing.columns = {}, must be 1 to {}", name, drawing.columns, kMostColumns));
  leave_out_empty(drawing.charts);
  if (drawing.charts.empty()) return bad_input(name + ": drawing.charts has no line, at least one is needed");
  return drawing;
}

void add_study_draw_options(CLI::App& command, StudyDrawOptions& o) {
  command.add_option("study", o.study, "The file that --json of a study wrote")->type_name("FILE")->required();
  add_plot_files(command, o.picture, "Draw its charts as a PNG (needs gnuplot)");
  add_path(command, "--svg", o.picture.svg, "The same as an SVG, light or dark as the browser prefers");
  command.footer(
      "Examples:\n"
      "  poise study population --json population.json                          measures for an hour\n"
      "  poise study draw population.json --picture light.png --picture-dark dark.png      and draws in a second");
}

int study_draw(const StudyDrawOptions& o) {
  const Status sound = check_plot_files(o.picture);
  if (!sound) return refuse("study draw", kExitBadUsage, sound.error().message);
  if (!o.picture.any())
    return refuse("study draw", kExitBadUsage, "one of --picture, --picture-dark and --svg is needed");
  const Status apart =
      check_outputs({{"--picture", o.picture.png}, {"--picture-dark", o.picture.png_dark}, {"--svg", o.picture.svg}},
                    {{"FILE", o.study}});
  if (!apart) return refuse("study draw", kExitBadUsage, apart.error().message);
  const Result<std::string> json = geometry::read_text_file(o.study, kMostBytes);
  if (!json) return refuse("study draw", json.error());
  const Result<StudyDrawing> drawing = drawing_of(json.value(), o.study);
  if (!drawing) return refuse("study draw", drawing.error());
  const parallel::Interrupt interrupt;
  const Status drawn =
      draw_by_gnuplot(charts_plot(drawing.value().charts, drawing.value().columns), o.picture, interrupt);
  return drawn ? kExitDone : refuse("study draw", drawn.error());
}

}  // namespace poise::app
