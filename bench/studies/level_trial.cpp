// SPDX-License-Identifier: MIT
#include "studies/level_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "app/process/refusal.h"
#include "geometry/mesh/procedural.h"
#include "poise/assets/mesh_file.h"

namespace poise::app {
namespace {

constexpr double kDensityKgpm3 = 1000;
constexpr double kFrameS = 1.0 / 60;
// Step in which the engine follows the flight to find the time of its impulse, and how long before the contact it
// starts. Chosen: a step is an eighth of the promised error of time, and no level gives an impulse earlier at 2 m/s
// (measured: 0.36 s at level 0).
constexpr double kStepS = 1e-3;
constexpr double kLeadS = 0.5;
// Number of states (contacts and moments before them) over which costs are measured. With fewer, the branch predictor
// would memorise them.
constexpr std::size_t kCostStates = 500;
constexpr int kCostRounds = 5;

BodyState state_of(const oracle::Flight& flight, double time_s) {
  const oracle::Placed at = flight.at(time_s);
  return {at.position_m, at.orientation, flight.velocity_mps, flight.spin_radps};
}

simulation::PairState state_of(const oracle::RandomTouch& touch, double time_s) {
  return {state_of(touch.a, time_s), state_of(touch.b, time_s)};
}

// Result of one model for one contact at one level.
struct Sample {
  double dv_mps = 0, dw_mps = 0;  // errors
  double off_ms = 0, early_ms = 0;
  bool late = false, seen = true;
};

struct TouchResult {
  oracle::RandomTouch touch;
  double changed = 0, changed_three = 0;  // change of the exact result when b is moved
  std::vector<Sample> samples;            // in the order of models, then levels
};

// Data that each worker has separately.
struct Worker {
  std::vector<std::optional<simulation::PairProbe>> probes;  // one for each model
};

struct Trial {
  const TrialShape& a;
  const TrialShape& b;
  const TrialSettings& settings;
};

// Mean of rho |dw| over the two bodies: the speed at the radius sqrt(I / m) due to the change of spin.
double spin_speed(const Trial& trial, const Vec3& dw_a, const Vec3& dw_b) {
  return 0.5 * (trial.a.body.angular_response_m() * dw_a.norm() + trial.b.body.angular_response_m() * dw_b.norm());
}

// The time at which the engine, stepped along the flight, first gives the pair an impulse; empty if it never does.
std::optional<double> time_of_answer(const oracle::RandomTouch& touch, simulation::PairProbe& probe,
                                     simulation::ProbeLevel level) {
  const double exact_s = touch.touch.time_s;
  const auto first = static_cast<std::int64_t>(std::max(0.0, std::floor((exact_s - kLeadS) / kStepS)));
  const auto last = static_cast<std::int64_t>(std::ceil((exact_s + 1e-3 * io::kLongestWaitMs) / kStepS));
  for (std::int64_t step = first; step <= last; ++step) {
    const double time_s = static_cast<double>(step) * kStepS;
    if (probe.acts(state_of(touch, time_s), level, kStepS)) return time_s;
  }
  return std::nullopt;
}

Sample sample_of(const Trial& trial, const oracle::RandomTouch& touch, simulation::PairProbe& probe,
                 simulation::ProbeLevel level) {
  Sample sample;
  const simulation::PairImpulse answer = probe.impulse(state_of(touch, touch.touch.time_s), level, trial.settings.dt_s);
  sample.seen = answer.met;
  sample.dv_mps = (answer.dv_a_mps - touch.answer.dv_a_mps).norm();
  sample.dw_mps =
      spin_speed(trial, answer.dw_a_radps - touch.answer.dw_a_radps, answer.dw_b_radps - touch.answer.dw_b_radps);
  const std::optional<double> time_s = time_of_answer(touch, probe, level);
  const double late_ms = time_s ? 1e3 * (*time_s - touch.touch.time_s) : io::kLongestWaitMs;
  sample.off_ms = std::abs(late_ms);
  sample.early_ms = std::max(0.0, -late_ms);
  sample.late = late_ms > 1e3 * kFrameS;
  return sample;
}

TouchResult result_of(const Trial& trial, std::uint64_t number, Worker& worker) {
  TouchResult result;
  const oracle::OracleMesh& a = trial.a.body;
  const oracle::OracleMesh& b = trial.b.body;
  result.touch = oracle::random_touch(a, b, trial.settings.throws, number);
  if (result.touch.touch.outcome != oracle::FlightOutcome::Touch) return result;
  const double size_m = std::min(a.size_m(), b.size_m());
  const auto changed = [&](double share, std::uint64_t draw) {
    const oracle::Answer moved =
        oracle::shifted_answer(a, b, trial.settings.throws, result.touch, share * size_m, draw);
    return (moved.dv_a_mps - result.touch.answer.dv_a_mps).norm();
  };
  result.changed = changed(1e-3, 0);
  result.changed_three = changed(3e-3, 1);
  for (std::optional<simulation::PairProbe>& probe : worker.probes) {
    for (const simulation::ProbeLevel level : trial.settings.levels) {
      result.samples.push_back(sample_of(trial, result.touch, *probe, level));
    }
  }
  return result;
}

simulation::PairSettings pair_settings(const Trial& trial, ContactModel model) {
  return {trial.a.shape, trial.b.shape, model, trial.settings.throws.restitution, kDensityKgpm3};
}

Result<std::vector<Worker>> make_workers(const Trial& trial, int count) {
  std::vector<Worker> workers(static_cast<std::size_t>(count));
  for (Worker& worker : workers) {
    for (const simulation::NamedContactModel& model : trial.settings.models) {
      Result<simulation::PairProbe> probe = simulation::PairProbe::make(pair_settings(trial, model.model));
      if (!probe) return probe.error();
      worker.probes.emplace_back(std::move(probe).value());
    }
  }
  return workers;
}

io::LevelsPair pair_of(const Trial& trial, const std::vector<TouchResult>& results) {
  io::LevelsPair pair;
  pair.shape_a = trial.a.name;
  pair.shape_b = trial.b.name;
  pair.group = !trial.a.procedural || !trial.b.procedural ? "other" : trial.a.round && trial.b.round ? "round" : "flat";
  pair.touches = results.size();
  const auto count = static_cast<double>(results.size());
  for (const TouchResult& result : results) {
    const oracle::RandomTouch& touch = result.touch;
    pair.missed += static_cast<std::size_t>(touch.missed);
    pair.grazing += static_cast<std::size_t>(touch.grazing);
    pair.undecided += static_cast<std::size_t>(touch.undecided);
    const oracle::Feature feature = touch.touch.nearest.feature;
    ++(feature == oracle::Feature::EdgeEdge ? pair.edge_edge
       : feature == oracle::Feature::Other  ? pair.other
                                            : pair.vertex_face);
    pair.dv_mps += touch.answer.dv_a_mps.norm() / count;
    pair.dw_mps += spin_speed(trial, touch.answer.dw_a_radps, touch.answer.dw_b_radps) / count;
    pair.uncertainty += result.changed / count;
    pair.uncertainty_three += result.changed_three / count;
  }
  pair.uncertainty /= pair.dv_mps;
  pair.uncertainty_three /= pair.dv_mps;
  return pair;
}

io::LevelsRow row_of(const std::vector<TouchResult>& results, std::size_t place, const io::LevelsPair& pair) {
  io::LevelsRow row;
  std::vector<double> dv;
  std::vector<double> dw;
  const auto count = static_cast<double>(results.size());
  for (const TouchResult& result : results) {
    const Sample& sample = result.samples[place];
    dv.push_back(sample.dv_mps);
    dw.push_back(sample.dw_mps);
    row.toc_ms_mean += sample.off_ms / count;
    row.toc_early_ms_mean += sample.early_ms / count;
    row.late_share += (sample.late ? 1 : 0) / count;
    row.unseen_share += (sample.seen ? 0 : 1) / count;
  }
  row.dv = spread_of(std::move(dv), pair.dv_mps);
  row.dw = spread_of(std::move(dw), pair.dw_mps);
  return row;
}

// The states of the contacts, and of moments before them.
std::vector<simulation::PairState> cost_states(const std::vector<TouchResult>& results) {
  std::vector<simulation::PairState> states;
  for (int back = 0; states.size() < kCostStates; ++back) {
    for (const TouchResult& result : results) {
      if (states.size() == kCostStates) break;
      states.push_back(state_of(result.touch, result.touch.touch.time_s - back * kStepS));
    }
  }
  return states;
}

Status add_rows(const Trial& trial, const std::vector<TouchResult>& results, io::LevelsDocument& document) {
  const io::LevelsPair pair = pair_of(trial, results);
  const std::vector<simulation::PairState> states = cost_states(results);
  std::vector<io::LevelsRow> rows;
  for (std::size_t m = 0; m < trial.settings.models.size(); ++m) {
    const simulation::NamedContactModel& model = trial.settings.models[m];
    const auto& levels = trial.settings.levels;
    const auto costs = simulation::PairProbe::costs(pair_settings(trial, model.model), states, levels,
                                                    trial.settings.dt_s, kCostRounds);
    if (!costs) return costs.error();
    for (std::size_t i = 0; i < levels.size(); ++i) {
      io::LevelsRow row = row_of(results, m * levels.size() + i, pair);
      row.pair = document.pairs.size();
      row.model = model.name;
      row.level = levels[i];
      row.cost = costs.value()[i];
      rows.push_back(std::move(row));
    }
  }
  document.pairs.push_back(pair);
  document.rows.insert(document.rows.end(), rows.begin(), rows.end());
  return Done{};
}

TriangleMesh scaled_to_one_metre(TriangleMesh mesh) {
  Vec3 least = mesh.vertices_m.front();
  Vec3 most = least;
  for (const Vec3& vertex : mesh.vertices_m) {
    least = least.cwiseMin(vertex);
    most = most.cwiseMax(vertex);
  }
  const double scale = 1 / (most - least).maxCoeff();
  for (Vec3& vertex : mesh.vertices_m) vertex *= scale;
  return mesh;
}

}  // namespace

io::ErrorSpread spread_of(std::vector<double> values, double whole) {
  if (!(whole > 0)) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  io::ErrorSpread spread;
  for (const double value : values) spread.mean += value / static_cast<double>(n);
  const auto rank = [&](std::size_t percent) { return values[(n * percent + 99) / 100 - 1]; };
  spread.median = rank(50);
  spread.p90 = rank(90);
  return {spread.mean / whole, spread.median / whole, spread.p90 / whole};
}

Result<TrialShape> make_trial_shape(const std::string& name, int fineness, const TreeBuildOptions& build,
                                    const TreeCacheSettings& cache, TreeCacheOutcome& outcome) {
  const auto known = geometry::procedural_shapes();
  const bool procedural = std::ranges::find(known, std::string_view(name)) != known.end();
  Result<TriangleMesh> mesh = procedural ? geometry::make_procedural_shape(name, fineness) : read_mesh(name, {});
  if (!mesh) return mesh.error();
  if (!procedural) mesh = scaled_to_one_metre(std::move(mesh).value());
  const Result<oracle::OracleMesh> body = oracle::OracleMesh::make(mesh.value(), kDensityKgpm3);
  if (!body) return bad_input(fmt::format("{}: {}", name, body.error().message));
  const Result<SphereTree> tree = cached_sphere_tree(mesh.value(), build, cache, &outcome);
  if (!tree) return tree.error();
  const Result<ShapePtr> shape = make_mesh_shape_with_tree(mesh.value(), tree.value());
  if (!shape) return shape.error();
  const std::string shown = procedural ? name : std::filesystem::path(name).stem().string();
  return TrialShape{shown, body.value(), shape.value(), name == "jack" || name == "torus" || name == "bowl",
                    procedural};
}

Status try_pair(const TrialShape& a, const TrialShape& b, const TrialSettings& settings, parallel::Executor& executor,
                const std::stop_token& stop, io::LevelsDocument& document) {
  const Trial trial{a, b, settings};
  Result<std::vector<Worker>> workers = make_workers(trial, executor.concurrency());
  if (!workers) return workers.error();
  std::vector<TouchResult> results(settings.touches);
  parallel::parallel_for(executor, results.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t i = begin; i < end && !stop.stop_requested(); ++i) {
      const std::uint64_t number = settings.half == "all" ? i : 2 * i + (settings.half == "report" ? 1 : 0);
      results[i] = result_of(trial, number, workers.value()[static_cast<std::size_t>(worker)]);
    }
  });
  if (stop.stop_requested()) return stopped_error();
  for (const TouchResult& result : results) {
    if (result.samples.empty())
      return bad_input(fmt::format("{} and {}: thrown at each other they do not touch", a.name, b.name));
  }
  return add_rows(trial, results, document);
}

}  // namespace poise::app
