// SPDX-License-Identifier: MIT
#include "studies/study_accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <ctime>

#include "accuracy/accuracy_case.h"
#include "app/files/output_files.h"
#include "app/files/scene_files.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "parallel/interrupt.h"
#include "scene/result_file.h"
#include "studies/accuracy_document.h"
#include "studies/gnuplot.h"
#include "studies/study_charts.h"
#include "studies/study_draw.h"

namespace poise::app {
namespace {

Result<std::vector<accuracy::Case>> chosen(const StudyAccuracyOptions& options) {
  std::vector<accuracy::Case> cases;
  for (const accuracy::Case& c : accuracy::all_cases()) {
    const bool wanted = options.only.empty() || std::ranges::any_of(options.only, [&](const std::string& o) {
                          return accuracy::matches(c.name, o);
                        });
    if (wanted) cases.push_back(c);
  }
  if (cases.empty())
    return bad_input(
        fmt::format("--only: no case has \"{}\" in its name; --list shows them", fmt::join(options.only, "\", \"")));
  return cases;
}

Status check(const StudyAccuracyOptions& options) {
  if (options.json == "-" && options.markdown == "-")
    return bad_input("only one of --json and --markdown can go to the standard output");
  const Status picture = check_plot_files(options.picture);
  if (!picture) return picture;
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.tree_cache);
  if (!cache) return cache.error();
  return check_outputs({{"--json", options.json},
                        {"--markdown", options.markdown},
                        {"--picture", options.picture.png},
                        {"--picture-dark", options.picture.png_dark},
                        {"--svg", options.picture.svg}},
                       {});
}

ExecutorKind executor_for(int threads) {
  if (threads == 1) return ExecutorKind::Serial;
#ifdef POISE_APP_HAVE_TBB
  return ExecutorKind::Tbb;
#else
  return ExecutorKind::Threads;
#endif
}

Result<accuracy::Context> make_context(const StudyAccuracyOptions& options, const parallel::Interrupt& interrupt) {
  const std::vector<std::filesystem::path> scenes = shipped_scenes();
  if (scenes.empty()) return bad_input("the scenes that ship are not installed");
  accuracy::Context context;
  context.threads = static_cast<int>(options.threads.value_or(1));
  context.executor = executor_for(context.threads);
  context.heaps = options.heaps.value_or(context.heaps);
  context.scenes = scenes.front().parent_path();
  context.tree_cache = tree_cache_settings(options.tree_cache).value();
  context.stop = interrupt.token();
  return context;
}

io::AccuracyDocument document_of(const accuracy::Context& context, double cpu_s) {
  io::AccuracyDocument d;
  for (const accuracy::Row& row : context.rows) {
    d.rows.push_back({row.case_name, row.figure, row.unit, row.value, row.at_most, row.published, row.ok()});
  }
  for (const accuracy::Series& s : context.series) d.series.push_back({s.case_name, s.time_s, s.drift_m, s.kinetic_j});
  d.threads = context.threads;
  d.cpu_s = cpu_s;
  d.machine = io::this_machine();
  d.build = io::this_build();
  return d;
}

Status write_all(const StudyAccuracyOptions& o, const io::AccuracyDocument& document,
                 const parallel::Interrupt& interrupt) {
  std::vector<LineChart> charts = io::accuracy_charts(document);
  leave_out_empty(charts);
  Status written = write_to(o.json, with_charts(io::accuracy_json(document), charts, 1));
  add_failure(write_to(o.markdown, io::accuracy_markdown(document)), written);
  if (o.json != "-" && o.markdown != "-" && !o.quiet)
    add_failure(io::write_stdout(io::accuracy_table(document)), written);
  if (o.page_charts != nullptr) {
    *o.page_charts = io::accuracy_charts(document);
    o.page_charts->push_back(io::bounds_chart(document));
    leave_out_empty(*o.page_charts);
  }
  if (!o.picture.any()) return written;
  if (document.series.empty()) {
    add_failure(bad_input("--picture: none of the chosen cases has anything to draw; those that stand for 60 s do"),
                written);
    return written;
  }
  add_failure(draw_by_gnuplot(charts_plot(charts, 1), o.picture, interrupt), written);
  return written;
}

int study(const StudyAccuracyOptions& options, const std::vector<accuracy::Case>& cases) {
  const parallel::Interrupt interrupt;
  Result<accuracy::Context> made = make_context(options, interrupt);
  if (!made) return refuse("study accuracy", made.error());
  accuracy::Context& context = made.value();
  Progress progress(!options.quiet);
  const std::clock_t start = std::clock();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    context.case_name = cases[i].name;
    const std::string doing = fmt::format("{} of {}: {}", i + 1, cases.size(), cases[i].name);
    context.progress = [&](double share) { progress.share(doing, share); };
    progress.say(doing);
    const Status done = cases[i].run(context);
    if (done) continue;
    progress.end();
    return refuse("study accuracy", interrupt.asked() ? stopped_error() : done.error());
  }
  progress.end();
  const io::AccuracyDocument document =
      document_of(context, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  const Status written = write_all(options, document, interrupt);
  if (!written) return refuse("study accuracy", written.error());
  return io::missed(document) == 0 ? kExitDone : kExitRequirementFailed;
}

}  // namespace

void add_study_accuracy_options(CLI::App& command, StudyAccuracyOptions& o) {
  command.add_option("--only", o.only, "Cases with this in their name, * for anything; may be given several times")
      ->type_name("PATTERN");
  command.add_flag("--list", o.list, "List the cases with what is expected of them, and run none");
  add_whole(command, "--threads", o.threads, 0, 256, "Threads, 0 = as many as the machine has (default 1)");
  add_whole(
      command, "--heaps", o.heaps, 1, 1000,
      "Heaps of each kind that fall and settle in 'levels change' (default 12): that of the scene, and those of the "
      "seeds behind its own");
  add_path(command, "--json", o.json, "Write the rows as JSON (poise.accuracy/1), - for the standard output");
  add_path(command, "--markdown", o.markdown, "Write the table for docs, - for the standard output");
  add_plot_files(command, o.picture, "Draw drift and kinetic energy of what stands over time as a PNG (needs gnuplot)");
  add_path(command, "--svg", o.picture.svg, "The same as an SVG, light or dark as the browser prefers");
  add_tree_cache_options(command, o.tree_cache);
  command.add_flag("--quiet", o.quiet, "No table and no progress");
  command.footer(
      "Examples:\n"
      "  poise study accuracy --markdown accuracy.md --picture accuracy.png      what docs/accuracy.md shows; takes "
      "minutes\n"
      "  poise study accuracy --only slope --only 'hard:*mass' --json -\n\n"
      "Cases whose outcome is known: closed forms, quantities that are conserved, structures that stand, hard cases "
      "that must stay sane. The\n"
      "exit code is 1 if a row is beyond its bound. Figures do not depend on threads; CPU times do on the machine.");
}

int study_accuracy(const StudyAccuracyOptions& options) {
  if (options.list) {
    std::string text;
    for (const accuracy::Case& c : accuracy::all_cases()) text += fmt::format("{:<34}{}\n", c.name, c.expected);
    const Status written = io::write_stdout(text);
    return written ? kExitDone : refuse("study accuracy", written.error());
  }
  const Status sound = check(options);
  if (!sound) return refuse("study accuracy", kExitBadUsage, sound.error().message);
  const Result<std::vector<accuracy::Case>> cases = chosen(options);
  if (!cases) return refuse("study accuracy", kExitBadUsage, cases.error().message);
  const Status writable =
      can_write({options.json, options.markdown, options.picture.png, options.picture.png_dark, options.picture.svg});
  if (!writable) return refuse("study accuracy", writable.error());
  return study(options, cases.value());
}

}  // namespace poise::app
