// SPDX-License-Identifier: MIT
#include "studies/gnuplot.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <iterator>
#include <string_view>

#include "app/refusal.h"
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

Status draw_into(const std::string& path, const std::string& script, const parallel::Interrupt& interrupt) {
  if (path.empty()) return Done{};
  const Result<std::string> picture = drawn_by_gnuplot(script, interrupt);
  return picture ? io::write_file(path, picture.value()) : Status(picture.error());
}

constexpr const char* kPlotColors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00",
                                       "#56b4e9", "#7d2e99", "#303840", "#9aa2ab"};

}  // namespace

std::string plot_color(std::size_t line) { return kPlotColors[line % std::size(kPlotColors)]; }

std::string plot_style(std::size_t width_px, std::size_t height_px) {
  std::string text = fmt::format(
      "set terminal pngcairo size {},{} font \"sans,13\" background rgb \"#fafafb\"\n"
      "set border 0\nset tics scale 0 textcolor rgb \"#303840\"\nset grid xtics ytics back lt 1 lw 1 lc rgb "
      "\"#d3d8de\"\nset key outside below horizontal textcolor rgb \"#303840\"\n",
      width_px, height_px);
  for (std::size_t i = 0; i < std::size(kPlotColors); ++i)
    text +=
        fmt::format("set linetype {} lc rgb \"{}\" lw 2.5 pt {} ps 1.2\n", i + 1, kPlotColors[i], i % 2 == 0 ? 7 : 5);
  return text + fmt::format("set linetype cycle {}\n", std::size(kPlotColors));
}

std::string svg_script(std::string script) {
  constexpr std::string_view kPng = "set terminal pngcairo ";
  const std::size_t at = script.find(kPng);
  if (at != std::string::npos) script.replace(at, kPng.size(), "set terminal svg ");
  return script;
}

Status draw_by_gnuplot(const std::string& script, const std::string& png, const std::string& svg,
                       const parallel::Interrupt& interrupt) {
  Status drawn = draw_into(png, script, interrupt);
  const Status other = draw_into(svg, svg_script(script), interrupt);
  // Without gnuplot neither can be drawn, which is told once.
  const bool same = !drawn && !other && drawn.error().message == other.error().message;
  if (!same) add_failure(other, drawn);
  return drawn;
}

}  // namespace poise::app
