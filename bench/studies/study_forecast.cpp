// SPDX-License-Identifier: MIT
#include "studies/study_forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "studies/forecast_trial.h"

namespace poise::app {
namespace {

constexpr const char* kForecastScene = "pile";
constexpr std::uint64_t kForecastFrames = 3000;
constexpr std::uint64_t kForecastWarmUp = 0;
// Number of frames for learning before a method is measured. Chosen: the start of a run is not typical of its
// forecasts.
constexpr std::size_t kSkip = 200;

// Where frames that are never too long stand on the logarithmic axis, in %.
constexpr double kNever = 0.01;

std::vector<LineChart> forecast_charts(const io::StudyTable& table) {
  LineChart chart{"reserves",
                  "reserve / needed",
                  "Further left and further down is better. None too long: drawn at 0.01 %.",
                  "frames that took longer than their reserve, %",
                  {},
                  {},
                  true};
  for (const auto& row : table.rows) {
    const std::string& method = std::get<std::string>(row[2]);
    if (std::ranges::find(chart.lines, method, &ChartLine::label) != chart.lines.end()) continue;
    std::vector<LinePoint> points = io::study_points(table, "exceeded", "reserve_over_actual", {{"method", method}});
    for (LinePoint& point : points) point.x = std::max(point.x, kNever);
    std::ranges::sort(points, {}, &LinePoint::x);
    chart.lines.push_back({method, std::move(points), LineMarks::Dots});
  }
  return {std::move(chart)};
}

}  // namespace

void add_study_forecast_options(CLI::App& command, StudyForecastOptions& o) {
  add_study_times_options(command, o.common, kForecastScene, kForecastFrames, kForecastWarmUp);
  command.add_option("--bodies", o.bodies, "Populations, with commas between them (default 100,2000)")
      ->delimiter(',')
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1000000}))
      ->type_name("LIST");
  command
      .add_option("--alpha", o.alphas,
                  "Shares of frames that may take longer, with commas between them (default 0.01,0.001)")
      ->delimiter(',')
      ->check(numbers_within(1e-5, 0.5))
      ->type_name("LIST");
  command.add_flag("--undisturbed", o.undisturbed,
                   "Leave out frames of which the machine took time away, to see the program's own variation alone");
  command.footer(
      "Examples:\n"
      "  poise study forecast --markdown forecast.md --picture forecast.png      what docs/deadlines.md shows; 2 "
      "minutes\n"
      "  poise study forecast --scene gas --bodies 500 --alpha 0.05 --json -\n\n"
      "Frames are recorded once, back to back under the deadline, and each method is played on the same ones, knowing "
      "only those before.\n"
      "The first 200 are not counted, nor is more than the first half.");
}

int study_forecast(const StudyForecastOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound)
    return refuse("study forecast", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<StudyScene> scene = StudyScene::make(o.common, kForecastScene);
  if (!scene) return refuse("study forecast", scene.error());
  const std::vector<std::uint64_t> populations = o.bodies.empty() ? std::vector<std::uint64_t>{100, 2000} : o.bodies;
  const std::vector<double> alphas = o.alphas.empty() ? std::vector<double>{0.01, 0.001} : o.alphas;
  Progress progress(!o.common.quiet);
  io::StudyTable table = begin_study("forecast", "poise study forecast");
  table.columns = {{"bodies", "bodies", 0},
                   {"alpha", "alpha", 3},
                   {"method", "method", 0},
                   {"exceeded", "longer than the reserve %", 2},
                   {"reserve_over_actual", "reserve / needed", 2},
                   {"pinball", "pinball loss %", 3},
                   {"beyond_clip", "beyond clip", 0}};
  table.facts = {{"scene", scene.value().name()},
                 {"frames", o.common.frames.value_or(kForecastFrames)},
                 {"deadline_ms", scene.value().deadline_ms()},
                 {"undisturbed", o.undisturbed},
                 {"threads", static_cast<std::uint64_t>(scene.value().threads())}};
  for (const std::uint64_t bodies : populations) {
    StudyRun run;
    run.bodies = bodies;
    run.frames = o.common.frames.value_or(kForecastFrames);
    run.warm_up = o.common.warmup.value_or(kForecastWarmUp);
    const auto frames = scene.value().run(run, fmt::format("{} bodies", bodies), progress);
    if (!frames) {
      progress.end();
      return refuse("study forecast", frames.error());
    }
    const std::vector<simulation::RecordedTail> tails = simulation::recorded_tails(frames.value(), o.undisturbed);
    for (const double alpha : alphas) {
      for (const simulation::ForecastScore& score :
           simulation::try_forecasts(tails, alpha, std::min(kSkip, tails.size() / 2))) {
        table.rows.push_back({bodies, alpha, score.method, 100 * score.exceeded, score.reserve_over_actual,
                              100 * score.pinball, score.beyond_clip});
      }
    }
  }
  progress.end();
  const Status written = write_study(o.common, table, forecast_charts(table), 1);
  return written ? kExitDone : refuse("study forecast", written.error());
}

}  // namespace poise::app
