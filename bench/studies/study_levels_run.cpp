// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <utility>

#include "app/files/output_files.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "scene/result_file.h"
#include "studies/gnuplot.h"
#include "studies/level_trial.h"
#include "studies/study_charts.h"
#include "studies/study_draw.h"
#include "studies/study_levels.h"

namespace poise::app {
namespace {

using Shapes = std::map<std::string, TrialShape>;

Result<Shapes> make_shapes(const StudyLevelsOptions& options, const LevelsPlan& plan, Progress& progress,
                           const parallel::Interrupt& interrupt) {
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.tree_cache);
  if (!cache) return cache.error();
  Shapes shapes;
  bool kept = true;
  for (const auto& [a, b] : plan.pairs) {
    for (const std::string& name : {a, b}) {
      if (shapes.contains(name)) continue;
      TreeBuildOptions build;
      build.depth = static_cast<Level>(options.depth.value_or(4));
      build.threads = static_cast<int>(options.threads.value_or(0));
      build.stop = interrupt.token();
      build.progress = [&](double share) { progress.share(fmt::format("tree of {}", name), share); };
      TreeCacheOutcome outcome{};
      Result<TrialShape> shape =
          make_trial_shape(name, static_cast<int>(options.fineness.value_or(8)), build, cache.value(), outcome);
      if (!shape && shape.error().kind == ErrorKind::Cancelled) return stopped_error();
      if (!shape) return shape.error();
      kept = kept && outcome != TreeCacheOutcome::NotWritable;
      shapes.emplace(name, std::move(shape).value());
    }
  }
  if (!kept) {
    progress.end();
    print_error("poise study levels: {}\n", tree_cache_warning(cache.value()));
  }
  return shapes;
}

io::LevelsDocument begin_document(const StudyLevelsOptions& options, const TrialSettings& settings, int threads) {
  io::LevelsDocument d;
  d.half = settings.half;
  d.seed = settings.throws.seed;
  d.touches = settings.touches;
  d.depth = static_cast<int>(options.depth.value_or(4));
  d.fineness = static_cast<int>(options.fineness.value_or(8));
  d.threads = threads;
  d.speed_mps = settings.throws.speed_mps;
  d.spin_radps = settings.throws.spin_radps;
  d.restitution = settings.throws.restitution;
  d.dt_s = settings.dt_s;
  d.machine = io::this_machine();
  d.build = io::this_build();
  return d;
}

Status write_all(const StudyLevelsOptions& o, const io::LevelsDocument& document,
                 const parallel::Interrupt& interrupt) {
  std::vector<LineChart> charts = io::levels_charts(document);
  leave_out_empty(charts);
  Status written = write_to(o.json, with_charts(io::levels_json(document), charts, 2));
  add_failure(write_to(o.csv, io::levels_csv(document)), written);
  add_failure(write_to(o.markdown, io::levels_markdown(document)), written);
  const bool taken = o.json == "-" || o.markdown == "-" || o.csv == "-";
  if (!taken && !o.quiet) add_failure(io::write_stdout(io::levels_table(document)), written);
  if (o.page_charts != nullptr) *o.page_charts = charts;
  add_failure(draw_by_gnuplot(charts_plot(charts, 2), o.picture, interrupt), written);
  return written;
}

int study(const StudyLevelsOptions& options, const LevelsPlan& plan, Progress& progress,
          const parallel::Interrupt& interrupt) {
  TrialSettings settings;
  settings.models = plan.models;
  settings.levels = plan.levels;
  settings.half = options.half;
  settings.touches = options.touches.value_or(100);
  settings.throws.seed = options.seed.value_or(1);
  const Result<Shapes> shapes = make_shapes(options, plan, progress, interrupt);
  if (!shapes) {
    progress.end();
    return refuse("study levels", shapes.error());
  }
  const auto executor = parallel::make_executor(ExecutorKind::Tbb, static_cast<int>(options.threads.value_or(0)));
  io::LevelsDocument document = begin_document(options, settings, executor->concurrency());
  for (std::size_t i = 0; i < plan.pairs.size(); ++i) {
    const TrialShape& a = shapes.value().at(plan.pairs[i].first);
    const TrialShape& b = shapes.value().at(plan.pairs[i].second);
    progress.share(fmt::format("pair {} of {}: {} {}", i + 1, plan.pairs.size(), a.name, b.name),
                   static_cast<double>(i) / static_cast<double>(plan.pairs.size()));
    const Status tried = try_pair(a, b, settings, *executor, interrupt.token(), document);
    if (!tried) {
      progress.end();
      return refuse("study levels", tried.error());
    }
  }
  progress.end();
  const Status written = write_all(options, document, interrupt);
  return written ? kExitDone : refuse("study levels", written.error());
}

}  // namespace

int study_levels(const StudyLevelsOptions& options) {
  const Result<LevelsPlan> plan = plan_of(options);
  if (!plan) return refuse("study levels", kExitBadUsage, plan.error().message);
  const Status writable = can_write({options.json, options.csv, options.markdown, options.picture.png,
                                     options.picture.png_dark, options.picture.svg});
  if (!writable) return refuse("study levels", writable.error());
  for (const std::string& name : plan.value().missing)
    print_error("poise study levels: not installed, left out: {}\n", name);
  Progress progress(!options.quiet);
  const parallel::Interrupt interrupt;
  return study(options, plan.value(), progress, interrupt);
}

}  // namespace poise::app
