// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/picture/chart_theme.h"
#include "scene/run/percentiles.h"
#include "studies/gnuplot.h"
#include "studies/study_charts.h"
#include "studies/study_gaze.h"

namespace poise::app {
namespace {

// Share of the cells at each end that the scale of colours leaves out, so that single cells do not rule it. Chosen.
constexpr double kOutOfScale = 0.03;
// Largest over least error of a scale. Chosen.
constexpr double kLeastRange = 1.01;

using CellErrors = std::vector<std::optional<double>>;

// Light is small: viridis (van der Walt and Smith 2015) the other way round, which grows evenly darker, also for people
// with impaired colour vision and in grey.
constexpr const char* kPalette =
    "set palette defined (0 \"#fde725\", 1 \"#a0da39\", 2 \"#4ac16d\", 3 \"#1fa187\", 4 \"#277f8e\", 5 \"#365c8d\", "
    "6 \"#46327e\", 7 \"#440154\")\n";

std::string cells_block(const CellErrors& cells, std::size_t point) {
  std::string text = fmt::format("$cells{} << EOD\n", point);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double column = static_cast<double>(i % kCellsAcross) + 0.5;
    const double row = static_cast<double>(i / kCellsAcross) + 0.5;
    if (cells[i]) text += fmt::format("{:g} {:g} {:g}\n", column, row, *cells[i]);
  }
  return text + "EOD\n";
}

// What is as far from the gaze as *near* goes, in cells.
std::string ring_block(const GazeCamera& camera, std::size_t point) {
  std::string text = fmt::format("$ring{} << EOD\n", point);
  const View gazing = gazing_at(camera, point);
  const Vec3 side = gazing.gaze.cross(gazing.up).normalized();
  const Vec3 up = side.cross(gazing.gaze);
  constexpr int kCorners = 72;
  for (int k = 0; k <= kCorners; ++k) {
    const double turn = 2 * std::numbers::pi * k / kCorners;
    const Vec3 direction =
        gazing.gaze + std::tan(kNear_deg * kGazeDegreeRad) * (std::cos(turn) * side + std::sin(turn) * up);
    const ScreenPlace place = on_screen(gazing, gazing.position_m + direction);
    text += fmt::format("{:g} {:g}\n", place.across * kCellsAcross, place.down * kCellsDown);
  }
  return text + "EOD\n";
}

// The maps side by side above, with one scale of colours for all.
std::string maps(const GazeRun& run, std::uint64_t seed) {
  std::vector<CellErrors> all;
  std::vector<double> errors_mps;
  for (std::size_t point = 0; point < kGazePoints; ++point) {
    all.push_back(gaze_cells(run.states, point));
    for (const std::optional<double>& cell : all.back()) {
      if (cell) errors_mps.push_back(*cell);
    }
  }
  const double least = simulation::percentile(errors_mps, kOutOfScale);
  const double most = simulation::percentile(errors_mps, 1 - kOutOfScale);
  // gnuplot refuses a scale without a range.
  if (!(most > kLeastRange * least)) return "";
  const std::vector<NearRatio> near = near_ratios(run.states, seed);
  std::string text = std::string(kPalette) + "unset xtics\nunset ytics\nunset key\nset grid noxtics noytics\n";
  text += fmt::format(
      "set xrange [0:{0}]\nset yrange [{1}:0]\nset cbrange [{2:g}:{3:g}]\nset cblabel \"error, m/s\"\n"
      "set cbtics textcolor rgb \"{4}\"\nset cblabel textcolor rgb \"{4}\"\n"
      "set object 1 rectangle from graph 0,0 to graph 1,1 fs solid border lc rgb \"{5}\" fc rgb \"{5}\" behind\n",
      kCellsAcross, kCellsDown, least, most, color_text(kChartInk), color_text(kChartGrid));
  for (std::size_t point = 0; point < kGazePoints; ++point) {
    text += cells_block(all[point], point) + ring_block(run.camera, point);
    const std::string less =
        near[point].ratio ? fmt::format(": in the ring {:.2f} of elsewhere", *near[point].ratio) : std::string();
    text += point + 1 == kGazePoints ? "set colorbox user origin 0.925,0.615 size 0.012,0.285\n" : "unset colorbox\n";
    text += fmt::format(
        "set lmargin at screen {:g}\nset rmargin at screen {:g}\nset bmargin at screen 0.60\nset tmargin at screen "
        "0.91\nset title \"gaze {}{}\" textcolor rgb \"{}\"\n",
        0.02 + 0.3 * static_cast<double>(point), 0.02 + 0.3 * static_cast<double>(point) + 0.29, kGazeNames[point],
        less, color_text(kChartInk));
    text += fmt::format(
        "plot $cells{0} using 1:2:(0.51):(0.51):3 with boxxyerror fc palette fs solid noborder, $ring{0} with lines lw "
        "4 lc rgb \"white\", $ring{0} with lines lw 1.5 lc rgb \"black\"\n",
        point);
  }
  return text + "unset object 1\nset xtics scale 0\nset ytics scale 0\nset grid xtics ytics\nset autoscale\n";
}

std::vector<LinePoint> curve(const std::vector<double>& values) {
  std::vector<LinePoint> points;
  const auto half = static_cast<std::ptrdiff_t>(values.size() / 2);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::ptrdiff_t frame = static_cast<std::ptrdiff_t>(i) - half;
    if (frame >= -static_cast<std::ptrdiff_t>(kBeforeFrames))
      points.push_back({static_cast<double>(frame), values[i], {}, {}});
  }
  return points;
}

LineChart jump_chart(const GazeRun& run) {
  LineChart chart{"jump",
                  "mean level of contacts near two points, as the gaze jumps",
                  "Within 5 degrees of each.",
                  "frame; 0 is the first with the new gaze",
                  {}};
  chart.y_from_data = true;
  if (run.jumps.empty()) return chart;
  chart.lines.push_back(
      {"near the new point", curve(mean_over_jumps(run.jumps, &GazeJump::at_new, &PairLevels::level_mean))});
  chart.lines.push_back(
      {"near the old one", curve(mean_over_jumps(run.jumps, &GazeJump::at_old, &PairLevels::level_mean))});
  return chart;
}

LineChart bins_chart(const GazeRun& run) {
  LineChart chart{"bins",
                  "error by distance from the gaze, over the three points, m/s",
                  "",
                  "degrees from the gaze",
                  {{"gaze here", {}}, {"gaze elsewhere", {}}, {"all refined", {}}}};
  // Over the three gaze points.
  std::array<std::array<double, 3>, kEccentricityBins> sums{};
  std::array<double, kEccentricityBins> bodies{};
  for (const GazeBinRow& row : gaze_bins(run.states)) {
    const auto count = static_cast<double>(row.bodies);
    const std::array values{row.e_mps, row.elsewhere_mps, row.full_e_mps};
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double value = values[k].value_or(0);
      sums[row.bin][k] += count * value * value;
    }
    bodies[row.bin] += count;
  }
  for (std::size_t bin = 0; bin < kEccentricityBins; ++bin) {
    chart.x_names.push_back(bin == 0 ? fmt::format("0-{:g}", kBinEnds_deg[0])
                            : bin < kBinEnds_deg.size()
                                ? fmt::format("{:g}-{:g}", kBinEnds_deg[bin - 1], kBinEnds_deg[bin])
                                : fmt::format("> {:g}", kBinEnds_deg.back()));
    for (std::size_t k = 0; k < chart.lines.size() && bodies[bin] > 0; ++k)
      chart.lines[k].points.push_back({static_cast<double>(bin), std::sqrt(sums[bin][k] / bodies[bin]), {}, {}});
  }
  return chart;
}

}  // namespace

std::vector<LineChart> gaze_charts(const GazeRun& run) {
  std::vector<LineChart> charts{jump_chart(run), bins_chart(run)};
  leave_out_empty(charts);
  return charts;
}

std::string gaze_plot(const GazeRun& run, std::uint64_t seed) {
  constexpr PictureSize kSize{1400, 740};
  constexpr double kChartsHeight = 400;
  std::string text = plot_style(1400, 740) + "set multiplot\n" + maps(run, seed);
  const std::vector<LineChart> charts = gaze_charts(run);
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const double width = kSize.width / static_cast<double>(charts.size());
    text += panel_plot(charts[i], {width * static_cast<double>(i), 0, width, kChartsHeight}, kSize);
  }
  return text + "unset multiplot\n";
}

}  // namespace poise::app
