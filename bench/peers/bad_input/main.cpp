// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <string>

#include "bad_input/trial.h"

// bad_input ENGINE TRIAL: what an engine does with a bad input, as `trials.mjs` has it for the engines of npm: prints
// `VERSION<tab>refused: WHY` or `VERSION<tab>NUMBER OF BODIES<tab>BODIES THAT ARE NaN<tab>HEIGHT OF THE LAST<tab>LOWEST
// OTHER`. The program runs one trial, since it may be the last thing that it does.
namespace poise::bench {
namespace {

constexpr double kStep_s = 1.0 / 60;

struct Trial {
  TrialEngine engine;
  Status all = Done{};

  void add(const TrialBody& body) {
    if (all) all = engine.add(body);
  }
  void steps(int count, double dt_s = kStep_s) {
    for (int i = 0; i < count && all; ++i) all = engine.step(dt_s);
  }
  /// 27 balls of 1 kg in three layers, which touch.
  void heap() {
    for (int i = 0; i < 27; ++i) add({1, Vec3(0.5 * (i % 3 - 1), 0.5 * (i / 3 % 3 - 1), 0.25 + 0.5 * (i / 9))});
    steps(30);
  }
  void dropped_on_heap(double mass_kg, const Quat& orientation = Quat::Identity(), bool box = false) {
    heap();
    add({mass_kg, Vec3(0.1, 0.05, 2.5), orientation, box});
    steps(120);
  }
};

void run(Trial& trial, const std::string& name) {
  if (name == "nan-velocity") {
    trial.heap();
    if (trial.all) trial.all = trial.engine.set_velocity(13, Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
    trial.steps(90);
  } else if (name == "zero-mass") {
    trial.dropped_on_heap(0);
  } else if (name == "infinite-mass") {
    trial.dropped_on_heap(std::numeric_limits<double>::infinity());
  } else if (name == "mass-1e30") {
    trial.dropped_on_heap(1e30);
  } else if (name == "zero-quaternion") {
    trial.dropped_on_heap(1, Quat(0, 0, 0, 0), true);
  } else if (name == "dt-1000") {
    trial.heap();
    trial.steps(1, 1000);
    trial.steps(30);
  } else if (name == "dt-1e9") {
    trial.heap();
    trial.steps(1, 1e9);
    trial.steps(30);
  } else if (name == "gram-under-tonne") {
    trial.add({0.001, Vec3(0, 0, 0.25)});
    trial.add({1000, Vec3(0, 0, 0.75)});
    trial.steps(120);
  } else if (name == "inverted-mesh") {
    trial.add({1, Vec3(0.3, 0.2, 1)});
    trial.steps(120);
  } else if (name == "degenerate-mesh") {
    trial.heap();
    if (trial.all) trial.all = trial.engine.add_degenerate();
    trial.steps(120);
  } else {
    trial.all = bad_input("no such trial");
  }
}

int main_of(const std::string& engine, const std::string& name) {
  const std::map<std::string, TrialEngine (*)(Ground)> engines{
      {"Poise", trial_of_poise}, {"Bullet", trial_of_bullet}, {"ODE", trial_of_ode}};
  const auto found = engines.find(engine);
  if (found == engines.end()) return 2;
  Trial trial{found->second(name == "inverted-mesh" ? Ground::InsideOut : Ground::Plane)};
  run(trial, name);
  if (!trial.all) {
    std::printf("%s\trefused: %s\n", trial.engine.version.c_str(), trial.all.error().message.c_str());
    return 0;
  }
  const std::vector<Vec3> positions = trial.engine.positions_m();
  int lost = 0;
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const Vec3& position : positions) {
    if (!position.allFinite()) ++lost;
    if (&position != &positions.back()) lowest_m = std::fmin(lowest_m, position.z());
  }
  std::printf("%s\t%zu\t%d\t%.3g\t%.3g\n", trial.engine.version.c_str(), positions.size(), lost, positions.back().z(),
              lowest_m);
  return 0;
}

}  // namespace
}  // namespace poise::bench

int main(int argc, char** argv) { return argc == 3 ? poise::bench::main_of(argv[1], argv[2]) : 2; }
