// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "parallel/interrupt.h"
#include "scene/made_by.h"
#include "scene/result_file.h"
#include "soak/soak_figures.h"

// Lets bodies come and go for an hour, and says whether memory, handles, forecasts and replay are at the end what they
// were at the beginning (docs/reliability.md, "Long runs").
namespace poise::soak {
namespace {

struct Options {
  std::string scene = POISE_SOURCE_DIR "/scenes/pour.json", json;
  double minutes = 60;
  std::optional<std::uint64_t> cycles;
  std::optional<std::uint64_t> warm_up;
  std::uint64_t leak_bytes = 0;
  double deadline_ms = 8;
  SoakSettings soak;
  bool quiet = false;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--minutes", options.minutes, "How long, in wall time (default 60)")->check(CLI::PositiveNumber);
  app.add_option("--cycles", options.cycles, fmt::format("Instead: so many cycles of {} frames", kCycle))
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1'000'000}));
  app.add_option("--warm-up", options.warm_up, "Cycles before those that are compared (default 4, or a third)")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1000}));
  app.add_option("--per-second", options.soak.per_second, "Bodies that come while the tray is filled (default 1000)")
      ->check(CLI::Range(1.0, 1e5));
  app.add_option("--deadline", options.deadline_ms, "Of a frame, ms, which pulses from a quarter of it to twice (8)")
      ->check(CLI::Range(1e-3, 1e4));
  app.add_option("--work", options.soak.work, "Instead: node-pair expansions of a frame, the same on every machine")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1'000'000'000}))
      ->excludes("--deadline");
  app.add_option("--threads", options.soak.threads, "Threads of the World (default 2)")->check(CLI::Range(1, 256));
  app.add_option("--seed", options.soak.seed, "Of the bodies and of where the viewer looks");
  app.add_option("--scene", options.scene, "A scene of one stream, with a camera (default scenes/pour.json)");
  app.add_option("--json", options.json, "Write figures and checks (poise.soak/1), - for the standard output");
  app.add_option("--leak", options.leak_bytes, "Keep so many bytes of each frame, to see that this is found");
  app.add_flag("--quiet", options.quiet, "No table and no progress");
}

nlohmann::ordered_json document(const Options& options, const SoakCounts& counts, const SoakFigures& figures,
                                std::uint64_t warm_up, const std::vector<Check>& checks, double seconds) {
  nlohmann::ordered_json json;
  json["format"] = "poise.soak/1";
  json["machine"] = io::this_machine();
  json["build"] = io::this_build();
  json["seconds"] = seconds;
  json["frames"] = counts.frames;
  json["warm_up_cycles"] = warm_up;
  json["per_second"] = options.soak.per_second;
  if (options.soak.work)
    json["work_units"] = *options.soak.work;
  else
    json["deadline_ms"] = options.deadline_ms;
  json["threads"] = options.soak.threads;
  json["seed"] = options.soak.seed;
  json["bodies"] = {{"added", counts.added},
                    {"removed", counts.removed},
                    {"recycled", counts.recycled},
                    {"most_at_once", counts.most_at_once},
                    {"slots", counts.slots}};
  for (const Check& check : checks)
    json["checks"].push_back(
        {{"name", check.name}, {"holds", check.holds}, {"value", check.value}, {"bound", check.bound}});
  for (const CycleFigures& cycle : figures.cycles()) {
    json["cycles"].push_back({{"heap_bytes", cycle.heap_bytes},
                              {"resident_bytes", cycle.resident_bytes},
                              {"frames_that_allocated", cycle.frames_that_allocated},
                              {"late", cycle.late},
                              {"forecast", cycle.forecast},
                              {"covered", cycle.covered},
                              {"tail_over_forecast", cycle.ratio}});
  }
  return json;
}

Result<SoakCounts> soak(const Options& options, SoakFigures& figures, const parallel::Interrupt& interrupt) {
  const Result<Scene> scene = read_scene(options.scene);
  if (!scene) return scene.error();
  SoakSettings settings = options.soak;
  settings.deadline = Nanoseconds(static_cast<std::int64_t>(1e6 * options.deadline_ms));
  Result<SoakDrive> drive = SoakDrive::create(scene.value(), settings);
  if (!drive) return drive.error();
  std::vector<std::unique_ptr<char[]>> leak;
  const auto end =
      std::chrono::steady_clock::now() +
      std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double, std::ratio<60>>(options.minutes));
  const std::uint64_t cycles = options.cycles.value_or(std::numeric_limits<std::uint64_t>::max() / kCycle);
  while (drive.value().counts().frames < cycles * kCycle && !interrupt.asked() &&
         (options.cycles || std::chrono::steady_clock::now() < end)) {
    const Result<SoakFrame> frame = drive.value().step();
    if (!frame) return frame.error();
    figures.add(frame.value());
    if (options.leak_bytes > 0) leak.push_back(std::make_unique<char[]>(options.leak_bytes));
    if (options.quiet || drive.value().counts().frames % kCycle != 0) continue;
    const CycleFigures& cycle = figures.cycles().back();
    fmt::print(stderr,
               "cycle {}: heap {:.2f} MiB, resident {:.1f} MiB, {} frames allocated, {} late, tail / forecast {:.3f}\n",
               figures.cycles().size(), static_cast<double>(cycle.heap_bytes) / 1048576,
               static_cast<double>(cycle.resident_bytes) / 1048576, cycle.frames_that_allocated, cycle.late,
               cycle.ratio);
  }
  return drive.value().counts();
}

int run(const Options& options) {
  const parallel::Interrupt interrupt;
  SoakFigures figures;
  const auto begin = std::chrono::steady_clock::now();
  const Result<SoakCounts> counts = soak(options, figures, interrupt);
  if (!counts) {
    fmt::print(stderr, "poise-soak: {}\n", counts.error().message);
    return 3;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const std::uint64_t warm_up = options.warm_up.value_or(usual_warm_up(figures.cycles().size()));
  const std::vector<Check> checks = figures.checks(warm_up, counts.value());
  bool all = true;
  std::string table = fmt::format("{} frames in {:.0f} s, {} bodies came, at most {} at once\n", counts.value().frames,
                                  seconds, counts.value().added, counts.value().most_at_once);
  for (const Check& check : checks) {
    all = all && check.holds;
    table +=
        fmt::format("{:5} {:16} {} (bound: {})\n", check.holds ? "ok" : "FAILS", check.name, check.value, check.bound);
  }
  if (!options.quiet || !all) fmt::print(options.json == "-" ? stderr : stdout, "{}", table);
  if (!options.json.empty()) {
    const std::string text = document(options, counts.value(), figures, warm_up, checks, seconds).dump(2) + "\n";
    const Status written = options.json == "-" ? io::write_stdout(text) : io::write_file(options.json, text);
    if (!written) {
      fmt::print(stderr, "poise-soak: {}\n", written.error().message);
      return 4;
    }
  }
  return all ? 0 : 1;
}

}  // namespace
}  // namespace poise::soak

int main(int argc, char** argv) {
  poise::soak::Options options;
  CLI::App app(
      "Lets bodies come and go for an hour, and says whether anything grows, drifts or differs from its replay");
  add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  }
  return poise::soak::run(options);
}
