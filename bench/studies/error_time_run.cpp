// SPDX-License-Identifier: MIT
#include "studies/error_time_run.h"

#include <algorithm>
#include <chrono>
#include <unordered_map>

#include "app/compare/compare_loop.h"
#include "app/compare/state_trials.h"
#include "app/process/refusal.h"
#include "parallel/interrupt.h"
#include "scene/run/milliseconds.h"
#include "scene/run/policy_name.h"
#include "studies/other_engines.h"
#include "verify/reference_figures.h"
#include "verify/shared_reference.h"

namespace poise::app {
namespace {

io::ComparedStep compared(const ReferenceFigures& figures, double time_ms) {
  io::ComparedStep step;
  step.converged = figures.converged;
  step.e_mps = figures.e_mps;
  step.e_rel = figures.e_rel;
  step.e_seen_mps = figures.e_seen_mps;
  step.gap_mean_px = figures.gap_mean_px;
  step.false_rate = figures.false_rate;
  step.time_ms = time_ms;
  return step;
}

// One run that makes states, and everything that steps from them.
class Trials {
 public:
  Trials(const Scene& scene, SceneRun& run, const ErrorTimeSettings& settings, std::vector<bench::Engine> engines)
      : scene_(scene), run_(run), settings_(settings), engines_(std::move(engines)) {
    for (const RunBody& body : run.bodies()) {
      if (body.motion == MotionType::Dynamic) bodies_.push_back(body.id);
    }
    before_.resize(bodies_.size());
    after_.resize(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) body_in_[bodies_[i].slot] = i;
  }

  // All methods from the state before `frame`, to which the run is put back.
  Status measure(std::uint64_t frame, std::vector<MethodRun>& methods) {
    shared_.save(run_.world());
    for (MethodRun& method : methods) {
      if (interrupt_.asked()) return stopped_error();
      shared_.rewind(run_.world());
      const Result<io::ComparedStep> measured =
          method.method.kind == SettingKind::Iterations ? by_engine(frame, method) : by_poise(frame, method.method);
      if (!measured) return measured.error();
      method.steps.push_back(measured.value());
    }
    shared_.rewind(run_.world());
    return run_.world().set_policy(scene_.policy);
  }

 private:
  [[nodiscard]] StepInput input_at(std::uint64_t frame) const {
    return compared_input(scene_, scene_view(scene_, static_cast<double>(frame) * scene_.dt_s));
  }
  Status step(const StepInput& input, FrameReport* report = nullptr) {
    const FrameReport done = run_.world().step(input);
    if (report != nullptr) *report = done;
    if (done.status == StepStatus::Done) return Done{};
    return bad_input("a step was refused: its input is out of range");
  }

  Result<io::ComparedStep> by_poise(std::uint64_t frame, const StepMethod& method) {
    const bool to_level = method.kind == SettingKind::Level;
    Status done = run_.world().set_policy(to_level ? scene_.policy : method.policy);
    FrameReport report;
    StepInput input;
    for (std::uint64_t k = 0; done && k < settings_.history; ++k) {
      if (k + 1 == settings_.history) shared_.begin(run_.world());
      input = input_at(frame + k);
      if (to_level) {
        input.max_level = static_cast<Level>(method.setting);
      } else {
        input.budget = Budget::within(of_ms(method.setting));
      }
      done = step(input, &report);
    }
    if (!done) return done.error();
    return compared(shared_.compare(run_.world(), input), ms(report.times.total));
  }

  Result<io::ComparedStep> by_engine(std::uint64_t frame, MethodRun& method) {
    const bench::Engine& engine = *std::ranges::find(engines_, method.method.group, &bench::Engine::name);
    World& world = run_.world();
    for (std::size_t i = 0; i < bodies_.size(); ++i) before_[i] = world.state(bodies_[i]).value();
    engine.set_iterations(static_cast<int>(method.method.setting));
    engine.set_states(before_);
    for (std::uint64_t k = 0; k + 1 < settings_.history; ++k) engine.step();
    engine.read_states(before_);
    const auto begun = std::chrono::steady_clock::now();
    engine.step();
    const double time_ms = ms(std::chrono::steady_clock::now() - begun);
    engine.read_states(after_);
    // The same frame by Poise, for the reference of the engine's own state.
    Status done = world.set_policy(scene_.policy);
    for (std::size_t i = 0; done && i < bodies_.size(); ++i) done = world.set_state(bodies_[i], before_[i]);
    if (!done) return Error{ErrorKind::BadInput, engine.name + " left the range of states: " + done.error().message};
    shared_.begin(world);
    const StepInput input = input_at(frame + settings_.history - 1);
    done = step(input);
    if (!done) return done.error();
    std::vector<simulation::ComparedBody> touched;
    ReferenceFigures figures = shared_.compare(world, input, &touched);
    for (simulation::ComparedBody& body : touched) {
      const std::size_t i = body_in_.at(body.slot);
      body.dv_mps = after_[i].velocity_mps - before_[i].velocity_mps;
      body.dw_radps = after_[i].angular_velocity_radps - before_[i].angular_velocity_radps;
    }
    const bool converged = figures.converged;
    figures = simulation::compare_frames(touched, {}, input.view.present);
    figures.converged = converged;
    figures.false_rate.reset();
    method.own_e_rel.push_back(own_e_rel(engine, std::move(touched)));
    return compared(figures, time_ms);
  }

  // The error of the changes in `touched` against those of the same engine from before_ with its solver converged.
  std::optional<double> own_e_rel(const bench::Engine& engine, std::vector<simulation::ComparedBody> touched) {
    engine.set_states(before_);
    engine.set_iterations(kLimitIterations);
    engine.step();
    engine.read_states(after_);
    for (simulation::ComparedBody& body : touched) {
      const std::size_t i = body_in_.at(body.slot);
      body.reference_dv_mps = after_[i].velocity_mps - before_[i].velocity_mps;
      body.reference_dw_radps = after_[i].angular_velocity_radps - before_[i].angular_velocity_radps;
    }
    return simulation::compare_frames(touched, {}, false).e_rel;
  }

  const Scene& scene_;
  SceneRun& run_;
  const ErrorTimeSettings& settings_;
  std::vector<bench::Engine> engines_;
  std::vector<BodyId> bodies_;                              // those that are dynamic, as engines have them
  std::unordered_map<std::uint32_t, std::size_t> body_in_;  // slot to place in bodies_
  std::vector<BodyState> before_, after_;
  simulation::SharedReference shared_;
  parallel::Interrupt interrupt_;
};

std::vector<MethodRun> methods_of(const ErrorTimeSettings& settings, Level deepest,
                                  const std::vector<bench::Engine>& engines) {
  std::vector<MethodRun> methods;
  const auto add = [&](const std::string& group, SettingKind kind, double setting) -> StepMethod& {
    methods.emplace_back().method = {group, kind, setting};
    return methods.back().method;
  };
  for (const scheduler::Policy& policy : settings.policies) {
    for (const double deadline_ms : settings.deadlines_ms)
      add(io::policy_name(policy.kind), SettingKind::Deadline, deadline_ms).policy = policy;
  }
  for (Level level = 0; level <= deepest; ++level) add(kLevelsGroup, SettingKind::Level, level);
  for (const bench::Engine& engine : engines) {
    for (const int iterations : settings.iterations) add(engine.name, SettingKind::Iterations, iterations);
  }
  return methods;
}

Level deepest_of(const SceneRun& run) {
  Level deepest = 0;
  for (const ShapePtr& shape : run.shapes()) {
    if (shape->kind == ShapeKind::Tree) deepest = std::max(deepest, static_cast<Level>(shape->tree.depth()));
  }
  return deepest;
}

}  // namespace

Result<ErrorTimeRun> error_time_run(const Scene& scene, const SceneRunOptions& start, const ErrorTimeSettings& settings,
                                    const std::function<void(double share)>& told) {
  Result<SceneRun> run = SceneRun::create(scene, start);
  if (!run) return run.error();
  ErrorTimeRun made;
  std::vector<bench::Engine> engines;
  Result<std::vector<bench::Engine>> others = other_engines(scene, settings.bodies);
  if (!others) {
    made.why_none = others.error().message;
  } else {
    engines = std::move(others).value();
    if (engines.empty()) made.why_none = "none are built in";
  }
  for (const bench::Engine& engine : engines) made.engines.push_back(engine.name + " " + engine.version);
  made.methods = methods_of(settings, deepest_of(run.value()), engines);
  Trials trials(scene, run.value(), settings, std::move(engines));
  CompareSettings states;
  states.from_policy.policy = scene.policy;
  states.warm_up = settings.warm_up;
  states.every = settings.every;
  states.states = settings.states;
  const Status done = visit_states(
      scene, run.value(), states, [&](std::uint64_t frame) { return trials.measure(frame, made.methods); },
      [&](double share) {
        told(share);
        return true;
      });
  if (!done) return done.error();
  return made;
}

}  // namespace poise::app
