// SPDX-License-Identifier: MIT
// The studies whose figures are in the docs: a separate program that `poise study NAME` starts.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>

#include "app/options/suggestions.h"
#include "app/process/exit_codes.h"
#include "app/process/standard_streams.h"
#include "scene/made_by.h"
#include "studies/study_list.h"

namespace {

int run(int argc, char** argv) {
  CLI::App app("Makes the figures of the docs.", "poise study");
  const poise::io::BuildFacts build = poise::io::this_build();
  app.set_version_flag("--version", fmt::format("poise-study {} ({}, {}, {})", build.version, build.commit,
                                                build.compiler, build.flags));
  app.require_subcommand(0, 1);
  app.footer(
      "Example:\n  poise study trees --markdown trees.md\n  poise study levels --markdown levels.md\n  poise study "
      "accuracy --only slope\n\nEach study has its own --help.");
  int exit_code = poise::app::kExitDone;
  poise::app::add_studies(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& stop) {
    // --help and --version also end here, with 0; every error is bad usage.
    const int code = app.exit(stop);
    if (dynamic_cast<const CLI::ExtrasError*>(&stop) != nullptr)
      std::fputs(poise::app::argument_hints(app).c_str(), stderr);
    if (code != 0) return poise::app::kExitBadUsage;
    return std::fflush(stdout) == 0 ? poise::app::kExitDone : poise::app::kExitOutputFailed;
  }
  if (app.get_subcommands().empty()) {
    std::fprintf(stderr, "poise study: the name of a study is required; poise study --help lists them\n");
    return poise::app::kExitBadUsage;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  poise::app::open_standard_streams();
  // A reader that closes the pipe must lead to exit code 4, not to a signal.
  std::signal(SIGPIPE, SIG_IGN);
  // So must a file that reaches the limit of `ulimit -f`.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return run(argc, argv);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "poise study: %s\n", failure.what());
  } catch (...) {
    std::fprintf(stderr, "poise study: failed for an unknown reason\n");
  }
  return poise::app::kExitBadInput;
}
