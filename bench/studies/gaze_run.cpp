// SPDX-License-Identifier: MIT
#include "studies/gaze_run.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "app/process/refusal.h"
#include "frame/cues/pair_place.h"
#include "verify/shared_reference.h"
#include "verify/world_access.h"

namespace poise::app {
namespace {

constexpr double kNearRad = kNear_deg * kGazeDegreeRad;
// Last frames without a limit, in which the demand is measured; and frames with the budget before the first state,
// until what is left undone has grown as far as it does. Chosen.
constexpr std::uint64_t kDemandFrames = 60, kLeadFrames = 60;
constexpr std::size_t kLeft = 0, kCentre = 1, kRight = 2;

std::uint64_t share_of(double share, double units) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(1, std::llround(share * units)));
}

std::uint32_t cell_at(const ScreenPlace& place) {
  return static_cast<std::uint32_t>(static_cast<std::size_t>(place.down * kCellsDown) * kCellsAcross +
                                    static_cast<std::size_t>(place.across * kCellsAcross));
}

// Calls `visit` with each active pair of the last step that is in the picture: where it is by its root spheres, which
// does not depend on how it was refined, and its levels.
template <class Visit>
void visit_pairs(const simulation::WorldState& world, const View& view, const Visit& visit) {
  const simulation::Frame& frame = world.outputs;
  for (std::size_t i = 0; i < frame.table.size(); ++i) {
    const Vec3 point_m = simulation::place_of(frame.motion, frame.table.pairs[i]).point_m;
    if (!on_screen(view, point_m).inside) continue;
    const simulation::PairProgress& progress = frame.levels.progress[i];
    PairLevels levels;
    levels.pairs = 1;
    levels.answered = progress.refinable() ? 0 : 1;
    if (!progress.apart()) {
      levels.contacts = 1;
      levels.level_sum = progress.solved_level();
    }
    visit(point_m, levels);
  }
}

PairLevels levels_near(const simulation::WorldState& world, const View& view) {
  PairLevels sum;
  visit_pairs(world, view, [&](const Vec3& point_m, const PairLevels& levels) {
    if (eccentricity_rad(view, point_m) < kNearRad) sum.add(levels);
  });
  return sum;
}

/// One run, of one seed.
class GazeTrial {
 public:
  GazeTrial(DrivenScene driven, const std::string& scene_file, const GazeSettings& settings,
            const parallel::Interrupt* interrupt, const std::function<void()>& told, GazeRun& result)
      : driven_(std::move(driven)),
        scene_file_(scene_file),
        settings_(settings),
        interrupt_(interrupt),
        told_(told),
        result_(result) {}

  Status run() {
    World& world = driven_.world();
    Status done = world.set_policy(settings_.policy);
    double units = 0;
    for (std::uint64_t i = 0; done && i < settings_.settle; ++i) {
      done = frame({});
      if (i + kDemandFrames >= settings_.settle) units += static_cast<double>(report_.work_refine);
    }
    if (!done) return done;
    full_units_ = units / static_cast<double>(std::min(settings_.settle, kDemandFrames));
    if (!(full_units_ > 0))
      return bad_input(scene_file_ + ": has nothing to refine once it has settled, so a gaze changes nothing");
    budget_ = Budget::work(share_of(settings_.budget_share, full_units_));
    camera_ = overlooking(moving_places());
    scheduler::Policy without_gaze = settings_.policy;
    without_gaze.eccentricity = 0;
    done = world.set_policy(without_gaze);
    for (std::uint64_t i = 0; done && i < kLeadFrames + settings_.states * settings_.every; ++i)
      done = i >= kLeadFrames && (i - kLeadFrames) % settings_.every == 0 ? state(without_gaze) : frame(budget_);
    if (done) done = world.set_policy(settings_.policy);
    return done ? jump() : done;
  }

  [[nodiscard]] const GazeCamera& camera() const { return camera_; }
  [[nodiscard]] double full_units() const { return full_units_; }

 private:
  std::vector<Vec3> moving_places() {
    const dynamics::BodyStore& bodies = simulation::WorldAccess::of(driven_.world()).bodies;
    std::vector<Vec3> places_m;
    for (std::uint32_t slot = 0; slot < bodies.slot_count(); ++slot) {
      if (bodies.alive[slot] != 0 && bodies.dynamic[slot] != 0) places_m.push_back(bodies.position(slot));
    }
    if (places_m.empty()) places_m.emplace_back(Vec3::Zero());
    return places_m;
  }

  Result<StepInput> begin_frame() {
    if (interrupt_ != nullptr && interrupt_->asked()) return stopped_error();
    Result<StepInput> input = driven_.begin_frame();
    if (input) input.value().view = gazing_at(camera_, kCentre);
    return input;
  }

  Status end_frame(const StepInput& input) {
    const Result<FrameReport> report = driven_.end_frame(input);
    if (!report) return report.error();
    report_ = report.value();
    told_();
    return Done{};
  }

  Status frame(const Budget& budget) {
    Result<StepInput> input = begin_frame();
    if (!input) return input.error();
    input.value().budget = budget;
    return end_frame(input.value());
  }

  // Steps the state that is next in all ways; the run goes on from it as if it had not been.
  Status state(const scheduler::Policy& without_gaze) {
    const Result<StepInput> begun = begin_frame();
    if (!begun) return begun.error();
    StepInput input = begun.value();
    World& world = driven_.world();
    const simulation::WorldState& inside = simulation::WorldAccess::of(world);
    shared_.save(world);
    shared_.begin(world);
    GazeState state;
    Bodies bodies(inside.bodies.slot_count());
    const FrameReport full = world.step(input);
    if (full.status != StepStatus::Done) return bad_input("the step was refused: its input is out of range");
    state.full_units = static_cast<double>(full.work_refine);
    bool converged = compare(input, bodies, [](Compared& body, double eps2) { body.full_eps2 = eps2; });
    shared_.rewind(world);
    Status done = world.set_policy(settings_.policy);
    if (!done) return done;
    input.budget = budget_;
    for (std::size_t point = 0; point < kGazePoints; ++point) {
      input.view = gazing_at(camera_, point);
      world.step(input);
      converged = compare(input, bodies, [&](Compared& body, double eps2) { body.eps2[point] = eps2; }) && converged;
      visit_pairs(inside, input.view, [&](const Vec3& point_m, const PairLevels& levels) {
        state.levels[point][bin_of(eccentricity_rad(input.view, point_m))].add(levels);
      });
      shared_.rewind(world);
    }
    done = world.set_policy(without_gaze);
    input = begun.value();
    input.budget = budget_;
    if (done) done = end_frame(input);
    if (!done) return done;
    if (!converged) {
      ++result_.not_converged;
      return Done{};
    }
    add_bodies(bodies, state);
    result_.states.push_back(std::move(state));
    return Done{};
  }

  struct Compared {
    bool touched = false;
    std::array<double, kGazePoints> eps2{};
    double full_eps2 = 0;
  };
  using Bodies = std::vector<Compared>;

  // False: the reference has not converged.
  template <class Put>
  bool compare(StepInput input, Bodies& bodies, const Put& put) {
    input.view = {};  // one reference for all gazes
    const ReferenceFigures figures = shared_.compare(driven_.world(), input, &touched_);
    for (const simulation::ComparedBody& body : touched_) {
      bodies[body.slot].touched = true;
      put(bodies[body.slot], simulation::squared_error_m2ps2(body));
    }
    return figures.converged;
  }

  void add_bodies(const Bodies& bodies, GazeState& state) const {
    for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) {
      const Vec3 center_m = shared_.reference().bodies.position(slot);
      const ScreenPlace place = on_screen(camera_.view, center_m);
      if (!bodies[slot].touched || !place.inside) continue;
      GazeBody body;
      body.cell = cell_at(place);
      for (std::size_t point = 0; point < kGazePoints; ++point)
        body.eccentricity_rad[point] = eccentricity_rad(gazing_at(camera_, point), center_m);
      body.eps2 = bodies[slot].eps2;
      body.full_eps2 = bodies[slot].full_eps2;
      state.bodies.push_back(body);
    }
  }

  // The gaze rests on the left twice as long as between jumps, since the run had none before.
  Status jump() {
    const std::uint64_t hold = settings_.hold;
    std::vector<PairLevels> near_left, near_right;
    for (std::uint64_t i = 0; settings_.jumps > 0 && i < (settings_.jumps + 2) * hold; ++i) {
      Result<StepInput> input = begin_frame();
      if (!input) return input.error();
      const bool left = i < 2 * hold || (i / hold) % 2 != 0;
      input.value().view = gazing_at(camera_, left ? kLeft : kRight);
      input.value().budget = budget_;
      const Status done = end_frame(input.value());
      if (!done) return done;
      const simulation::WorldState& world = simulation::WorldAccess::of(driven_.world());
      near_left.push_back(levels_near(world, gazing_at(camera_, kLeft)));
      near_right.push_back(levels_near(world, gazing_at(camera_, kRight)));
    }
    for (std::uint64_t k = 0; k < settings_.jumps; ++k) {
      const auto first = static_cast<std::ptrdiff_t>((k + 1) * hold);
      const auto part = [&](const std::vector<PairLevels>& all) {
        return std::vector<PairLevels>(all.begin() + first,
                                       all.begin() + first + static_cast<std::ptrdiff_t>(2 * hold));
      };
      const bool to_right = k % 2 == 0;
      result_.jumps.push_back({part(to_right ? near_right : near_left), part(to_right ? near_left : near_right)});
    }
    return Done{};
  }

  DrivenScene driven_;
  const std::string& scene_file_;
  const GazeSettings& settings_;
  const parallel::Interrupt* interrupt_;
  const std::function<void()>& told_;
  GazeRun& result_;
  GazeCamera camera_;
  FrameReport report_;
  double full_units_ = 0;
  Budget budget_;
  simulation::SharedReference shared_;
  std::vector<simulation::ComparedBody> touched_;
};

}  // namespace

Result<GazeRun> run_gaze(const Scene& scene, const SceneRunOptions& options, const GazeSettings& settings,
                         const ShareSink& told, const parallel::Interrupt* interrupt) {
  // A body that falls asleep in one way of stepping and not in another would be measured from another state.
  Scene awake = scene;
  awake.sleeping = false;
  SceneRunOptions start = options;
  start.world.sleeping = false;
  start.world.islands_wait = IslandsWait::Never;
  const std::uint64_t frames = settings.settle + kLeadFrames + settings.states * settings.every +
                               (settings.jumps > 0 ? (settings.jumps + 2) * settings.hold : 0);
  std::uint64_t done = 0;
  const std::function<void()> count = [&] {
    told(static_cast<double>(++done) / static_cast<double>(settings.seeds * frames));
  };
  GazeRun result;
  for (std::uint64_t k = 0; k < settings.seeds; ++k) {
    start.seed = scene.seed + k;
    Result<DrivenScene> driven = DrivenScene::create(awake, start, settings.bodies, settings.bodies, settings.shake);
    if (!driven) return driven.error();
    GazeTrial trial(std::move(driven).value(), scene.source, settings, interrupt, count, result);
    const Status ran = trial.run();
    if (!ran) return ran.error();
    if (k == 0) result.camera = trial.camera();
    result.full_units += trial.full_units() / static_cast<double>(settings.seeds);
  }
  return result;
}

}  // namespace poise::app
