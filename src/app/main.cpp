// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string_view>

#include "app/capture/export_command.h"
#include "app/check/check_command.h"
#include "app/compare/compare_command.h"
#include "app/live/live_command.h"
#include "app/options/suggestions.h"
#include "app/process/exit_codes.h"
#include "app/process/standard_streams.h"
#include "app/replay/replay_command.h"
#include "app/report/view_command.h"
#include "app/run/run_command.h"
#include "app/scenes/import_command.h"
#include "app/scenes/scenes_command.h"
#include "app/scenes/shape_command.h"
#include "app/study/study_command.h"
#include "app/sweep/job_array_command.h"
#include "app/sweep/sweep_command.h"
#include "app/tree/tree_command.h"
#include "app/tune/tune_command.h"
#include "scene/made_by.h"

namespace {

int run(int argc, char** argv) {
  CLI::App app("Poise steps scenes of many rigid bodies inside a time budget.", "poise");
  const poise::io::BuildFacts build = poise::io::this_build();
  app.set_version_flag("--version",
                       fmt::format("poise {} ({}, {}, {})", build.version, build.commit, build.compiler, build.flags));
  app.require_subcommand(0, 1);
  app.footer("Example:\n  poise run two-body\n\nEach command has its own --help.");
  int exit_code = poise::app::kExitDone;
  poise::app::add_run_command(app, exit_code);
  poise::app::add_live_command(app, exit_code);
  poise::app::add_check_command(app, exit_code);
  poise::app::add_compare_command(app, exit_code);
  poise::app::add_replay_command(app, exit_code);
  poise::app::add_export_command(app, exit_code);
  poise::app::add_view_command(app, exit_code);
  poise::app::add_tree_command(app, exit_code);
  poise::app::add_shape_command(app, exit_code);
  poise::app::add_import_command(app, exit_code);
  poise::app::add_study_command(app);
  poise::app::add_sweep_command(app, exit_code);
  poise::app::add_tune_command(app);
  poise::app::add_job_array_command(app, exit_code);
  poise::app::add_scenes_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& stop) {
    // Help and the version end here too, with 0; every mistake is bad usage.
    const int code = app.exit(stop);
    if (dynamic_cast<const CLI::ExtrasError*>(&stop) != nullptr)
      std::fputs(poise::app::argument_hints(app).c_str(), stderr);
    if (code != 0) return poise::app::kExitBadUsage;
    const bool written = std::cout.flush().good() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    if (written) return poise::app::kExitDone;
    std::fprintf(stderr, "poise: standard output: cannot be written\n");
    return poise::app::kExitOutputFailed;
  }
  if (app.get_subcommands().empty()) {
    std::fprintf(stderr, "poise: a command is required; poise --help lists them\n");
    return poise::app::kExitBadUsage;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  poise::app::open_standard_streams();
  // Before anything else is read, so that every word behind it, --help too, is the study's or the search's.
  if (argc > 1 && std::string_view(argv[1]) == "study") return poise::app::start_study(argc, argv);
  if (argc > 1 && std::string_view(argv[1]) == "tune") return poise::app::start_tune(argc, argv);
  // A reader that goes away must end in exit code 4, not in a signal.
  std::signal(SIGPIPE, SIG_IGN);
  // So must a file that reaches the limit of `ulimit -f`, so that the other files are written.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr,
                 "poise: memory: the system gives no more of it; poise check SCENE says how much a scene needs\n");
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "poise: %s\n", failure.what());
  } catch (...) {
    std::fprintf(stderr, "poise: failed for an unknown reason\n");
  }
  return poise::app::kExitBadInput;
}
