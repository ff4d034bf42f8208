// SPDX-License-Identifier: MIT
#include "studies/gnuplot.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <regex>
#include <string_view>

#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "app/picture/chart_theme.h"
#include "app/process/refusal.h"
#include "scene/result_file.h"
#include "studies/child_command.h"

namespace poise::app {
namespace {

// gnuplot reads its script from a temporary file.
Result<std::string> drawn_by_gnuplot(const std::string& script, const parallel::Interrupt& interrupt) {
  std::error_code failure;
  std::string file = (std::filesystem::temp_directory_path(failure) / "poise-plot-XXXXXX").string();
  const int handle = failure ? -1 : ::mkstemp(file.data());
  if (handle < 0) return Error{ErrorKind::OutputFailed, fmt::format("{}: cannot be made", file)};
  ::close(handle);
  const Status written = io::write_file(file, script);
  const Result<ChildResult> child =
      written ? run_program({"gnuplot", file}, interrupt) : Result<ChildResult>(written.error());
  std::filesystem::remove(file, failure);
  if (!child)
    return Error{ErrorKind::OutputFailed, fmt::format("--picture needs gnuplot-nox: {}", child.error().message)};
  if (child.value().exit_code != 0) {
    return Error{ErrorKind::OutputFailed, fmt::format("--picture: gnuplot ended with {}", child.value().exit_code)};
  }
  return child.value().out;
}

Status draw_into(const std::string& path, const std::string& script, const parallel::Interrupt& interrupt,
                 std::string (*finish)(const std::string&) = nullptr) {
  if (path.empty()) return Done{};
  const Result<std::string> picture = drawn_by_gnuplot(script, interrupt);
  if (!picture) return picture.error();
  return io::write_file(path, finish == nullptr ? picture.value() : finish(picture.value()));
}

// gnuplot writes colours as rgb(r, g, b).
std::string with_hex_colors(const std::string& svg) {
  static const std::regex kRgb(R"(rgb\( *(\d+), *(\d+), *(\d+)\))");
  std::string text;
  auto from = svg.begin();
  for (std::sregex_iterator at(svg.begin(), svg.end(), kRgb), end; at != end; ++at) {
    const auto part = [&](std::size_t k) { return static_cast<std::uint8_t>(std::stoi((*at)[k])); };
    text.append(from, (*at)[0].first).append(color_text({part(1), part(2), part(3)}));
    from = (*at)[0].second;
  }
  text.append(from, svg.end());
  // Our rules are for attributes in double quotes.
  for (const char* name : {"fill='#", "stroke='#", "color='#"}) {
    for (std::size_t place = text.find(name); place != std::string::npos; place = text.find(name, place + 1)) {
      const std::size_t open = text.find('\'', place), close = text.find('\'', open + 1);
      text[open] = text[close] = '"';
    }
  }
  return text;
}

}  // namespace

std::string plot_color(std::size_t line) { return color_text(line_color(line)); }

std::string plot_style(std::size_t width_px, std::size_t height_px) {
  std::string text = fmt::format(
      "set terminal pngcairo size {0},{1} font \"sans,13\" background rgb \"{2}\"\n"
      "set border 0\nset tics scale 0 textcolor rgb \"{3}\"\nset grid xtics ytics back lt 1 lw 1 lc rgb "
      "\"{4}\"\nset key outside below horizontal textcolor rgb \"{3}\"\n",
      width_px, height_px, color_text(kChartGround), color_text(kChartInk), color_text(kChartGrid));
  for (std::size_t i = 0; i < kChartLines.size(); ++i)
    text +=
        fmt::format("set linetype {} lc rgb \"{}\" lw 2.5 pt {} ps 1.2\n", i + 1, plot_color(i), i % 2 == 0 ? 7 : 5);
  return text + fmt::format("set linetype cycle {}\n", kChartLines.size());
}

std::string svg_script(std::string script) {
  constexpr std::string_view kPng = "set terminal pngcairo ";
  const std::size_t at = script.find(kPng);
  if (at != std::string::npos) script.replace(at, kPng.size(), "set terminal svg ");
  return script;
}

std::string svg_of_gnuplot(const std::string& svg) { return svg_with_dark(with_hex_colors(svg), DarkPart::All); }

void add_plot_files(CLI::App& command, PlotFiles& files, const std::string& what) {
  add_path(command, "--picture", files.png, what);
  add_path(command, "--picture-dark", files.png_dark, "The same on a dark ground");
}

Status check_plot_files(const PlotFiles& files) {
  for (const auto& [option, file] : {std::pair("--picture", &files.png), std::pair("--picture-dark", &files.png_dark),
                                     std::pair("--svg", &files.svg)}) {
    if (*file == "-") return bad_input(fmt::format("{} must be a file", option));
  }
  const Status picture = check_picture(files.png);
  return picture ? check_picture(files.png_dark, "--picture-dark") : picture;
}

Status draw_by_gnuplot(const std::string& script, const PlotFiles& files, const parallel::Interrupt& interrupt) {
  Status drawn = draw_into(files.png, script, interrupt);
  const auto add = [&](const Status& other) {
    // Without gnuplot none can be drawn, which is told once.
    const bool same = !drawn && !other && drawn.error().message == other.error().message;
    if (!same) add_failure(other, drawn);
  };
  add(draw_into(files.png_dark, dark_text(script), interrupt));
  add(draw_into(files.svg, svg_script(script), interrupt, svg_of_gnuplot));
  return drawn;
}

}  // namespace poise::app
