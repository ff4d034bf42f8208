// SPDX-License-Identifier: MIT
// The scene `jacks` in Poise and in the engines that Debian has, interleaved in one run: milliseconds a step while the
// pile falls and when it is at rest, and the quality of the resulting piles. For the settings of each see
// docs/response.md.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "assets/files/atomic_file.h"
#include "peers/engine.h"
#include "peers/pile_figures.h"
#include "peers/turns.h"
#include "scene/made_by.h"

namespace poise::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::vector<std::uint64_t> bodies = {2000};
  std::uint64_t frames = 600;
  std::uint64_t block_frames = 10;
  int threads = 2;
  bool ode_flat = false;
  std::string scene = POISE_SOURCE_DIR "/scenes/jacks.json";
  std::string json;
};

/// Largest accepted overlap of a pile: at it the jack's thinnest part is still half outside.
constexpr double kMostOverlapM = 0.18;

struct Phase {
  const char* name;
  std::uint64_t begin, end;  ///< frames
};

// Phases of 600 frames: 60 to 180 and 500 to 600; scaled for other numbers.
std::array<Phase, 2> phases(std::uint64_t frames) {
  return {{{"falling", frames / 10, 3 * frames / 10}, {"rest", 5 * frames / 6, frames}}};
}

struct Row {
  std::string engine, version;
  int threads = 1;
  PileFigures pile;
  std::array<TimeFigures, 2> times;  ///< by phase
  [[nodiscard]] bool holds() const { return pile.holds(kMostOverlapM); }
};

Result<std::vector<Engine>> make_engines(const Scene& scene, const PileScene& pile, std::uint64_t bodies,
                                         const Options& options) {
  std::vector<Engine> engines;
  Result<Engine> one = make_poise(scene, bodies, 1);
  if (!one) return one.error();
  engines.push_back(std::move(one).value());
  if (options.threads > 1) {
    Result<Engine> more = make_poise(scene, bodies, options.threads);
    if (!more) return more.error();
    engines.push_back(std::move(more).value());
  }
  engines.push_back(make_bullet(pile));
  engines.push_back(make_ode(pile, false));
  if (options.ode_flat) engines.push_back(make_ode(pile, true));
  return engines;
}

/// Checks that all engines start in Poise's state, to single precision.
Status check_start(std::span<const Engine> engines, const PileScene& pile) {
  std::vector<BodyState> states(pile.start.size());
  for (const Engine& engine : engines) {
    engine.read_states(states);
    double far_m = 0;
    double turned = 0;
    for (std::size_t i = 0; i < states.size(); ++i) {
      far_m = std::max(far_m, (states[i].position_m - pile.start[i].position_m).norm());
      turned = std::max(turned, 1 - std::abs(states[i].orientation.dot(pile.start[i].orientation)));
    }
    if (!(far_m < 1e-4) || !(turned < 1e-5)) {
      return bad_input(fmt::format("{} starts {:g} m and a half-turn of 1 - cos = {:g} away from the scene",
                                   engine.name, far_m, turned));
    }
  }
  return Done{};
}

Result<std::vector<Row>> measure(const Scene& scene, std::uint64_t bodies, const Options& options) {
  const Result<PileScene> pile = pile_scene(scene, bodies);
  if (!pile) return pile.error();
  const Result<std::vector<Engine>> made = make_engines(scene, pile.value(), bodies, options);
  if (!made) return made.error();
  const std::vector<Engine>& engines = made.value();
  const Status alike = check_start(engines, pile.value());
  if (!alike) return alike.error();
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  const auto progress = [&](std::uint64_t done) {
    if (terminal)
      fmt::print(stderr, "\r{} bodies: {} of {} frames{}", bodies, done, options.frames,
                 done == options.frames ? "\n" : "");
  };
  const auto times = take_turns(engines, options.frames, options.block_frames, progress);
  std::vector<Row> rows;
  std::vector<BodyState> states(pile.value().start.size());
  for (std::size_t i = 0; i < engines.size(); ++i) {
    Row& row = rows.emplace_back();
    row.engine = engines[i].name;
    row.version = engines[i].version;
    row.threads = engines[i].threads;
    engines[i].read_states(states);
    row.pile = pile_figures(pile.value(), states);
    for (std::size_t p = 0; p < row.times.size(); ++p) {
      const Phase phase = phases(options.frames)[p];
      row.times[p] = time_figures(std::span(times[i]).subspan(phase.begin, phase.end - phase.begin));
    }
  }
  return rows;
}

/// Ratio of the median CPU time a thread, peer to Poise on one thread; empty if either pile does not hold or nothing
/// was timed.
std::optional<double> ratio(const Row& row, const Row& poise, std::size_t phase) {
  const TimeFigures& own = poise.times[phase];
  if (!row.holds() || !poise.holds() || row.times[phase].frames == 0 || !(own.cpu.p50_ms > 0)) return std::nullopt;
  return row.times[phase].cpu.p50_ms / own.cpu.p50_ms;
}

void print_table(std::uint64_t bodies, std::span<const Row> rows, const Options& options) {
  fmt::print(
      "\n{} jacks, {} frames in blocks of {}. ms a step; CPU time is a thread's; ratio of medians to poise on one "
      "thread\n",
      bodies, options.frames, options.block_frames);
  for (std::size_t p = 0; p < 2; ++p) {
    const Phase phase = phases(options.frames)[p];
    fmt::print("\n{:<22}{:>8}{:>10}{:>10}{:>20}{:>10}{:>10}{:>8}\n",
               fmt::format("{} ({} to {})", phase.name, phase.begin, phase.end), "threads", "CPU p50", "p99",
               "p25 to p75", "wall p50", "p99", "ratio");
    for (const Row& row : rows) {
      const TimeFigures& t = row.times[p];
      const std::optional<double> r = ratio(row, rows[0], p);
      fmt::print("{:<22}{:>8}{:>10.3f}{:>10.3f}{:>20}{:>10.3f}{:>10.3f}{:>8}\n", row.engine, row.threads, t.cpu.p50_ms,
                 t.cpu.p99_ms, fmt::format("{:.3f} to {:.3f}", t.cpu.p25_ms, t.cpu.p75_ms), t.wall.p50_ms,
                 t.wall.p99_ms, r ? fmt::format("{:.2f}", *r) : "-");
    }
  }
  fmt::print("\n{:<22}{:>8}{:>14}{:>16}{:>14}{:>18}{:>10}{:>7}\n", "the pile at the end", "threads", "mean height",
             "mean speed", "mean overlap", "greatest overlap", "outside", "holds");
  for (const Row& row : rows) {
    const PileFigures& f = row.pile;
    fmt::print("{:<22}{:>8}{:>12.3f} m{:>12.4f} m/s{:>11.2f} mm{:>15.1f} mm{:>10}{:>7}\n", row.engine, row.threads,
               f.mean_height_m, f.mean_speed_mps, 1e3 * f.mean_overlap_m, 1e3 * f.greatest_overlap_m, f.outside,
               row.holds() ? "yes" : "no");
  }
}

Json quantiles_json(const TimeFigures::Quantiles& q) {
  return {{"p25_ms", q.p25_ms}, {"p50_ms", q.p50_ms}, {"p75_ms", q.p75_ms}, {"p99_ms", q.p99_ms}};
}

void add_rows(std::uint64_t bodies, std::span<const Row> rows, const Options& options, Json& json) {
  for (const Row& row : rows) {
    const PileFigures& f = row.pile;
    Json& out = json.emplace_back();
    out = {{"bodies", bodies}, {"engine", row.engine}, {"version", row.version}, {"threads", row.threads}};
    for (std::size_t p = 0; p < 2; ++p) {
      const Phase phase = phases(options.frames)[p];
      const std::optional<double> r = ratio(row, rows[0], p);
      out[phase.name] = {{"first_frame", phase.begin},
                         {"end_frame", phase.end},
                         {"cpu_per_thread", quantiles_json(row.times[p].cpu)},
                         {"wall", quantiles_json(row.times[p].wall)},
                         {"ratio_to_poise", r ? Json(*r) : Json(nullptr)}};
    }
    out["end"] = {{"holds", row.holds()},
                  {"finite", f.finite},
                  {"mean_height_m", f.mean_height_m},
                  {"mean_speed_mps", f.mean_speed_mps},
                  {"greatest_speed_mps", f.greatest_speed_mps},
                  {"overlaps", f.overlaps},
                  {"mean_overlap_m", f.mean_overlap_m},
                  {"greatest_overlap_m", f.greatest_overlap_m},
                  {"outside", f.outside}};
  }
}

int fail(const std::string& what) {
  fmt::print(stderr, "bench_peers: {}\n", what);
  return 1;
}

int run(const Options& options) {
  const Result<Scene> scene = read_scene(options.scene);
  if (!scene) return fail(scene.error().message);
  const io::BuildFacts build = io::this_build();
  Json json = {{"schema", "poise.peers/1"},
               {"scene", scene.value().name},
               {"version", build.version},
               {"commit", build.commit},
               {"compiler", build.compiler},
               {"flags", build.flags},
               {"machine_threads", std::thread::hardware_concurrency()},
               {"dt_s", scene.value().dt_s},
               {"frames", options.frames},
               {"block_frames", options.block_frames},
               {"most_overlap_that_holds_m", kMostOverlapM},
               {"rows", Json::array()}};
  bool all_hold = true;
  for (const std::uint64_t bodies : options.bodies) {
    const Result<std::vector<Row>> rows = measure(scene.value(), bodies, options);
    if (!rows) return fail(rows.error().message);
    print_table(bodies, rows.value(), options);
    std::fflush(stdout);
    add_rows(bodies, rows.value(), options, json["rows"]);
    for (const Row& row : rows.value()) all_hold = all_hold && row.holds();
  }
  if (!options.json.empty()) {
    const Status written = geometry::write_file(options.json, json.dump(2) + "\n");
    if (!written) return fail(written.error().message);
  }
  return all_hold ? 0 : fail("a pile does not hold: its speed says nothing");
}

}  // namespace
}  // namespace poise::bench

int main(int argc, char** argv) {
  poise::bench::Options options;
  CLI::App app(
      "Steps the scene `jacks` by Poise, Bullet and ODE in turns and compares their times. Exit 1 if a pile does not "
      "hold.",
      "bench_peers");
  app.add_option("--bodies", options.bodies, "numbers of bodies, one pile after another (default 2000)")
      ->check(CLI::Range(1, 1'000'000))
      ->delimiter(',');
  app.add_option("--frames", options.frames, "steps of each engine; of 600: falling is 60 to 180, rest 500 to 600")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--block", options.block_frames, "frames of one engine before the next has its turn")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--threads", options.threads, "of the second Poise; 1: there is none")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_flag("--ode-flat", options.ode_flat, "ODE a second time, with the spheres of all bodies in one hash space");
  app.add_option("--scene", options.scene, "another scene of the same kind: one shape of spheres, one material, a tray")
      ->check(CLI::ExistingFile);
  app.add_option("--json", options.json, "writes all figures to this file");
  CLI11_PARSE(app, argc, argv);
  return poise::bench::run(options);
}
