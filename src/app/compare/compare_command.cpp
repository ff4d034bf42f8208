// SPDX-License-Identifier: MIT
#include "app/compare/compare_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include "app/capture/run_capture.h"
#include "app/compare/compare_options.h"
#include "app/compare/compare_report.h"
#include "app/compare/serve.h"
#include "app/files/output_files.h"
#include "app/files/scene_input.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/run/run_options.h"
#include "app/sweep/sweep_plan.h"
#include "parallel/interrupt.h"
#include "scene/compare/comparison_document.h"
#include "scene/result_file.h"
#include "sweep/trial.h"

namespace poise::app {
namespace {

Status write_results(const CompareOptions& options, const io::ComparisonDocument& document,
                     std::optional<FiguresFiles>& report) {
  Status written = write_to(options.json, options.json.empty() ? "" : io::comparison_json(document));
  add_failure(write_to(options.csv, options.csv.empty() ? "" : io::comparison_csv(document)), written);
  add_failure(write_to(options.svg, options.svg.empty() ? "" : comparison_svg(document)), written);
  if (report) add_failure(report->write(comparison_figures(document, command_line())), written);
  if (options.quiet) return written;
  std::string table = io::comparison_table(document);
  if (report) table += fmt::format("\nreport: {}\n", figures_page_of(options.report));
  if (options.json != "-") {
    add_failure(io::write_stdout(table), written);
  } else {
    print_error("{}", table);
  }
  return written;
}

SceneRunOptions run_options(const CompareOptions& options, const Scene& scene, const TreeCacheSettings& cache) {
  RunOptions run;
  run.threads = options.threads;
  SceneRunOptions start;
  start.world = world_settings(run, scene);
  // A body that falls asleep in one way of stepping and not in another would be measured from another state.
  start.world.sleeping = false;
  start.world.islands_wait = IslandsWait::Never;
  start.bodies = options.bodies;
  start.seed = options.seed;
  start.tree_cache = cache;
  return start;
}

// Before anything is loaded: what changes later is not what was asked for.
Result<StatesIdentity> identity_of(const SceneText& text, const Scene& scene) {
  Result<std::string> hash = sweep::scene_hash(text.text, scene);
  if (!hash) return hash.error();
  Result<std::string> program = program_identity();
  if (!program) return program.error();
  return StatesIdentity{std::move(hash).value(), std::move(program).value()};
}

// All but bodies and result.
io::ComparisonDocument document_of(const CompareOptions& options, const Scene& scene, const CompareSettings& settings) {
  io::ComparisonDocument document;
  document.scene = scene.name;
  document.budget_unit = budget_unit_name(settings.unit);
  document.clock = options.clock;
  document.seed = options.seed.value_or(scene.seed);
  document.history = settings.history;
  document.machine = io::this_machine();
  document.build = io::this_build();
  return document;
}

int compare(const CompareOptions& options) {
  // Told before a scene is read: the weights of its policy do not matter to what is checked here.
  const Result<CompareSettings> sound = compare_settings(options, {});
  if (!sound) return refuse("compare", kExitBadUsage, sound.error().message);
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.tree_cache);
  if (!cache) return refuse("compare", kExitBadUsage, cache.error().message);
  const Result<SceneText> text = read_scene_argument(options.scene, "compare", options.quiet);
  if (!text) return refuse("compare", text.error());
  std::vector<std::string> errors;
  Result<Scene> scene = parse_scene_text(text.value(), errors);
  for (const std::string& error : errors) refuse("compare", kExitBadInput, error);
  if (!scene) return exit_code_of(scene.error());
  const Status apart = check_compare_files(options, scene.value());
  if (!apart) return refuse("compare", kExitBadUsage, apart.error().message);
  if (options.bodies && scene.value().generators.empty()) {
    return refuse("compare", kExitBadUsage, "--bodies: the scene " + scene.value().name + " has no generators");
  }
  const Result<StatesIdentity> identity =
      options.serve ? identity_of(text.value(), scene.value()) : Result<StatesIdentity>(StatesIdentity{});
  if (!identity) return refuse("compare", identity.error());
  scene.value().sleeping = false;
  if (options.polygons) scene.value().polygons = true;
  Result<CompareSettings> settings = compare_settings(options, scene.value().policy);
  const Status files = read_policy_files(settings.value(), errors);
  for (const std::string& error : errors) refuse("compare", kExitBadInput, error);
  if (!files) return exit_code_of(files.error());
  // While policies are read from the standard input, a signal ends the command as it ends any reader.
  std::optional<parallel::Interrupt> interrupt;
  if (!options.serve) interrupt.emplace();
  const Status writable = can_write({options.json, options.csv, options.svg});
  if (!writable) return refuse("compare", writable.error());
  std::optional<FiguresFiles> report;
  if (!options.report.empty()) {
    Result<FiguresFiles> opened = FiguresFiles::open(options.report);
    if (!opened) return refuse("compare", opened.error());
    report.emplace(std::move(opened).value());
  }
  Progress progress(!options.quiet);
  SceneRunOptions start = run_options(options, scene.value(), cache.value());
  if (interrupt) start.stop = interrupt->token();
  start.tree_progress = [&progress](double share) {
    progress.share("loading shapes and building sphere trees", share);
  };
  if (!options.quiet) warn_of_threads("compare", start.world.threads);
  Result<SceneRun> run = SceneRun::create(scene.value(), start);
  if (!run) {
    progress.end();
    return refuse("compare", interrupt && interrupt->asked() ? stopped_error(kStoppedLoading) : run.error());
  }
  io::ComparisonDocument document = document_of(options, scene.value(), settings.value());
  document.bodies = run.value().bodies().size();
  if (options.serve) {
    const Status served = serve_policies(scene.value(), run.value(), settings.value(), document, identity.value(),
                                         std::cin, [&](double share) {
                                           progress.share("making states", share);
                                           return true;
                                         });
    progress.end();
    return served ? kExitDone : refuse("compare", served.error());
  }
  const Result<io::ComparedSteps> steps = compare_loop(scene.value(), run.value(), settings.value(), [&](double share) {
    progress.share("stepping and comparing", share);
    return !interrupt->asked();
  });
  progress.end();
  if (!steps) return refuse("compare", steps.error());
  // What is asked for from here on comes too late to stop anything.
  const bool stopped = interrupt->asked();
  document.result = io::compare_steps(steps.value(), document.seed);
  const Status written = write_results(options, document, report);
  if (!written) return refuse("compare", written.error());
  return stopped ? exit_stopped() : kExitDone;
}

}  // namespace

void add_compare_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand("compare", "Step the same states under several policies and budgets");
  add_compare_options(*command, *options);
  command->footer(
      "Examples:\n"
      "  poise compare jacks --bodies 300 --policies perceptual,random,fifo,oracle\n"
      "  poise compare pile --bodies 250 --budgets 500,2000,8000 --from 4000 --json pile.json --svg pile.svg\n"
      "  poise compare jacks --bodies 300 --policies perceptual,size,oracle --report out\n"
      "  poise compare jacks --bodies 1000 --clock wall --budgets 2,4,8 --history 20\n"
      "  echo mine.json | poise compare jacks --bodies 300 --from 25% --serve --quiet\n\n"
      "Exit codes: 0 done, 2 bad usage, 3 bad input, 4 output failed, 130 stopped by Ctrl-C (143 by SIGTERM) after "
      "the report of what was done.");
  command->callback([options, &exit_code] { exit_code = compare(*options); });
}

}  // namespace poise::app
