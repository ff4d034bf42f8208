// SPDX-License-Identifier: MIT
#include "studies/study_compliance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "parallel/busy_thread.h"

namespace poise::app {
namespace {

constexpr const char* kScene = "pile";
constexpr std::uint64_t kFrames = 5000;
constexpr std::uint64_t kWarmUp = 300;
constexpr std::uint64_t kMostBodies = 200'000;

double full_p95_ms(const std::vector<simulation::RunFrame>& frames) {
  return simulation::run_figures(frames, {false}).stages.back().ms.p95;
}

// The largest population for which 95 of 100 frames are refined to their end within the deadline, to within a
// twentieth.
Result<std::uint64_t> served_population(const StudyScene& scene, std::uint64_t warm_up, Progress& progress) {
  const auto fits = [&](std::uint64_t bodies) -> Result<bool> {
    StudyRun run;
    run.bodies = bodies;
    run.deadline = false;
    run.warm_up = warm_up;
    run.frames = 60;
    const auto frames = scene.run(
        run, fmt::format("how many bodies can be refined to the end in {:g} ms: {}?", scene.deadline_ms(), bodies),
        progress);
    if (!frames) return frames.error();
    return full_p95_ms(frames.value()) <= scene.deadline_ms();
  };
  std::uint64_t low = 0;
  std::uint64_t high = 125;
  for (; high <= kMostBodies; high *= 2) {
    const Result<bool> fit = fits(high);
    if (!fit) return fit.error();
    if (!fit.value()) break;
    low = high;
  }
  if (low == 0)
    return bad_input(fmt::format("not even {} bodies can be refined to the end in {:g} ms", high, scene.deadline_ms()));
  while (high - low > std::max<std::uint64_t>(low / 20, 1)) {
    const std::uint64_t middle = low + (high - low) / 2;
    const Result<bool> fit = fits(middle);
    if (!fit) return fit.error();
    (fit.value() ? low : high) = middle;
  }
  return low;
}

const std::vector<io::StudyColumn> kColumns = {
    {"alpha", "alpha", 3},
    {"population", "x served", 2},
    {"bodies", "bodies", 0},
    {"releases", "releases", 0},
    {"miss_rate", "misses %", 2},
    {"miss_low", "", 4},
    {"miss_high", "", 4},
    {"infeasible", "infeasible", 0},
    {"machine", "machine", 0},
    {"release", "", 0},
    {"overrun", "overrun", 0},
    {"forecast", "forecast", 0},
    {"own_rate", "forecast + overrun %", 3},
    {"own_low", "95 % from", 3},
    {"own_high", "to", 3},
    {"refinement_used", "refinement used %", 1},
    {"frames_with_pairs_left", "frames with work left", 0},
    {"degraded_frames", "degraded", 0},
    {"level_mean", "mean level", 2},
    {"frames_a_step", "frames a step", 1},
    {"held_mean", "bodies that waited", 0},
    {"frame_p99_ms", "p99 ms", 2},
    {"reserve_over_actual", "reserve / needed", 2},
    {"beyond_clip", "beyond clip", 0},
    {"complies", "", 0},
    {"compliance", "complies", 0},
};

std::uint64_t own_misses(const simulation::MissFigures& m) { return m.overrun + m.forecast + m.release; }

const char* name_of(Compliance compliance) {
  switch (compliance) {
    case Compliance::Complies:
      return "yes";
    case Compliance::OutOfReach:
      return "out of reach";
    case Compliance::Fails:
      break;
  }
  return "no";
}

std::vector<io::StudyCell> row_of(double alpha, double population, std::uint64_t bodies,
                                  const simulation::RunFigures& f, Compliance compliance) {
  const simulation::MissFigures& m = *f.misses;
  const std::uint64_t own = own_misses(m);
  const simulation::Interval interval = simulation::clopper_pearson(own, m.releases, 0.95);
  const double releases = static_cast<double>(std::max<std::uint64_t>(m.releases, 1));
  return {alpha,
          population,
          bodies,
          m.releases,
          100 * m.rate,
          100 * m.interval_95.low,
          100 * m.interval_95.high,
          m.infeasible,
          m.machine,
          m.release,
          m.overrun,
          m.forecast,
          100 * static_cast<double>(own) / releases,
          100 * interval.low,
          100 * interval.high,
          f.refinement_used ? io::StudyCell(100 * *f.refinement_used) : io::StudyCell(),
          f.work.frames_with_pairs_left,
          f.degraded.frames,
          f.level_mean ? io::StudyCell(*f.level_mean) : io::StudyCell(),
          f.frames_a_step() ? io::StudyCell(*f.frames_a_step()) : io::StudyCell(),
          f.held_mean(),
          f.frame_ms.p99,
          f.tail.frames > 0 ? io::StudyCell(f.tail.reserve_over_actual) : io::StudyCell(),
          f.tail.beyond_clip,
          compliance == Compliance::Complies,
          std::string(name_of(compliance))};
}

std::vector<LineChart> compliance_charts(const io::StudyTable& table, const std::vector<double>& alphas) {
  LineChart chart{"misses",
                  "misses by forecast or overrun, %",
                  "Bands: 95 % intervals. Dashed: what is allowed.",
                  "bodies, in multiples of what full refinement serves",
                  {},
                  {},
                  true};
  for (std::size_t i = 0; i < alphas.size(); ++i) {
    const std::vector<io::StudyFilter> only = {{"alpha", fmt::format("{:.6f}", alphas[i])}};
    std::vector<LinePoint> points = io::study_points(table, "population", "own_rate", only);
    const std::vector<LinePoint> low = io::study_points(table, "population", "own_low", only);
    const std::vector<LinePoint> high = io::study_points(table, "population", "own_high", only);
    for (std::size_t k = 0; k < points.size() && k < low.size() && k < high.size(); ++k) {
      points[k].low = low[k].y;
      points[k].high = high[k].y;
    }
    std::ranges::sort(points, {}, &LinePoint::x);
    chart.lines.push_back({fmt::format("alpha = {:g} %", 100 * alphas[i]), std::move(points)});
    chart.levels.push_back({fmt::format("allowed: {:g} %", 100 * alphas[i]), 100 * alphas[i], i});
  }
  return {std::move(chart)};
}

}  // namespace

Compliance compliance_of(const simulation::MissFigures& m, double alpha, std::optional<double> refinement_used) {
  // Least share of its time that refinement must use if it leaves work.
  constexpr double kUsed = 0.9;
  if (2 * m.infeasible > m.releases) return Compliance::OutOfReach;
  const simulation::Interval late = simulation::clopper_pearson(own_misses(m) + m.infeasible, m.releases, 0.95);
  const bool used = !refinement_used || *refinement_used >= kUsed;
  return late.low <= alpha && used ? Compliance::Complies : Compliance::Fails;
}

void add_study_compliance_options(CLI::App& command, StudyComplianceOptions& o) {
  add_study_times_options(command, o.common, kScene, kFrames, kWarmUp);
  command
      .add_option("--alpha", o.alphas, "Shares of frames that may miss, with commas between them (default 0.01,0.001)")
      ->delimiter(',')
      ->check(numbers_within(1e-5, 0.5))
      ->type_name("LIST");
  command
      .add_option("--populations", o.populations,
                  "Multiples of what full refinement serves, with commas (default 0.5,1,2,4,8)")
      ->delimiter(',')
      ->check(numbers_within(0.01, 100.0))
      ->type_name("LIST");
  add_whole(command, "--bodies", o.bodies, 10, kMostBodies,
            "How many bodies full refinement serves, instead of finding out");
  command.add_flag("--competing-load", o.competing_load, "Keep one processor busy with something else the while");
  command.footer(
      "Examples:\n"
      "  poise study compliance --markdown compliance.md --picture compliance.png      half an hour; nothing else "
      "should run\n"
      "  poise study compliance --competing-load --alpha 0.01 --json -\n"
      "  poise study compliance --frames 600 --bodies 2000 --populations 1,4\n\n"
      "Paced runs of one scene at several populations. Rates are raw; intervals are those of Clopper and Pearson. A "
      "row complies where the\n"
      "misses that the machine did not cause, infeasible frames included, may be as rare as alpha (lower end of the "
      "interval) and refinement used\n"
      "at least 90 % of its time in the frames that left work. A row is out of reach where more than half of the "
      "frames "
      "are infeasible: what every\n"
      "frame must do does not fit. The exit code is 1 if a row within reach does not comply.");
}

int study_compliance(const StudyComplianceOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound)
    return refuse("study compliance", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<StudyScene> scene = StudyScene::make(o.common, kScene);
  if (!scene) return refuse("study compliance", scene.error());
  const std::vector<double> alphas = o.alphas.empty() ? std::vector<double>{0.01, 0.001} : o.alphas;
  const std::vector<double> populations = o.populations.empty() ? std::vector<double>{0.5, 1, 2, 4, 8} : o.populations;
  const std::uint64_t warm_up = o.common.warmup.value_or(kWarmUp);
  Progress progress(!o.common.quiet);
  std::uint64_t served = o.bodies.value_or(0);
  if (served == 0) {
    const Result<std::uint64_t> found = served_population(scene.value(), warm_up, progress);
    if (!found) {
      progress.end();
      return refuse("study compliance", found.error());
    }
    served = found.value();
  }
  io::StudyTable table = begin_study(
      "compliance", o.competing_load ? "poise study compliance --competing-load" : "poise study compliance");
  table.columns = kColumns;
  table.facts = {{"scene", scene.value().name()},
                 {"served_bodies", served},
                 {"deadline_ms", scene.value().deadline_ms()},
                 {"threads", static_cast<std::uint64_t>(scene.value().threads())},
                 {"competing_load", o.competing_load}};
  bool all = true;
  std::optional<parallel::BusyThread> busy;
  const std::vector<int> processors = parallel::allowed_processors();
  if (o.competing_load) busy.emplace(processors.empty() ? -1 : processors.back());
  for (const double alpha : alphas) {
    for (const double population : populations) {
      StudyRun run;
      run.bodies = std::max<std::uint64_t>(
          1, static_cast<std::uint64_t>(std::llround(population * static_cast<double>(served))));
      run.alpha = alpha;
      run.paced = true;
      run.frames = o.common.frames.value_or(kFrames);
      run.warm_up = warm_up;
      const auto frames = scene.value().run(run, fmt::format("alpha {:g}, {} bodies", alpha, run.bodies), progress);
      if (!frames) {
        progress.end();
        return refuse("study compliance", frames.error());
      }
      const simulation::RunFigures figures = simulation::run_figures(frames.value(), {true, alpha});
      const Compliance compliance = compliance_of(*figures.misses, alpha, figures.refinement_used);
      table.rows.push_back(row_of(alpha, population, run.bodies, figures, compliance));
      all = all && compliance != Compliance::Fails;
    }
  }
  busy.reset();
  progress.end();
  const Status written = write_study(o.common, table, compliance_charts(table, alphas), 1);
  if (!written) return refuse("study compliance", written.error());
  return all ? kExitDone : kExitRequirementFailed;
}

}  // namespace poise::app
