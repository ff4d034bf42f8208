// SPDX-License-Identifier: MIT
#include "frame/run_frame.h"

#include <algorithm>

#include "frame/budget/crowds.h"
#include "frame/budget/frame_time.h"
#include "frame/budget/pause.h"
#include "frame/ccd/swept.h"
#include "frame/out_of_range.h"
#include "parallel/cpu_clock.h"
#include "parallel/ranges.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kCachedGrain = 1024;

// A stopwatch for stages that follow each other.
class Laps {
 public:
  Laps(const parallel::Executor& clock, SteadyClock::time_point start) : clock_(clock), last_(start) {}
  Nanoseconds lap() {
    const SteadyClock::time_point now = clock_.time();
    const Nanoseconds passed = now - last_;
    last_ = now;
    return passed;
  }
  /// When the last stage ended.
  [[nodiscard]] SteadyClock::time_point at() const { return last_; }

 private:
  const parallel::Executor& clock_;
  SteadyClock::time_point last_;
};

// Pairs of bodies that were removed since the last step start anew, also where their slots are used again; their
// contacts end.
void forget_removed(const dynamics::BodyStore& bodies, BodyChanges& changes, ContactCache& cache, ContactEvents& events,
                    parallel::Executor& executor) {
  std::vector<BodyId>& removed = changes.removed;
  if (removed.empty()) return;
  std::sort(removed.begin(), removed.end());
  // Of a slot that was used twice, the body of the last step: the oldest one.
  const auto first_of = [&](std::uint32_t slot) {
    return std::lower_bound(removed.begin(), removed.end(), BodyId{slot, 0});
  };
  const auto is_removed = [&](std::uint32_t slot) {
    const auto at = first_of(slot);
    return at != removed.end() && at->slot == slot;
  };
  const auto body_of = [&](std::uint32_t slot) { return is_removed(slot) ? *first_of(slot) : bodies.id_of(slot); };
  const auto is_of_removed = [&](std::size_t i) {
    return is_removed(cache.pairs[i].low) || is_removed(cache.pairs[i].high);
  };
  const std::size_t count = cache.pairs.size();
  std::vector<std::uint32_t>& released = cache.points.released;
  const std::size_t released_before = released.size();
  std::vector<std::size_t>& counts = changes.counts;
  parallel::select(
      executor, count, kCachedGrain, counts,
      [&](std::size_t i) { return is_of_removed(i) && cache.pairs[i].slot != kNoSlot; },
      [&](std::size_t ended) { released.resize(released_before + ended); },
      [&](std::size_t i, std::size_t position) { released[released_before + position] = cache.pairs[i].slot; });
  const std::size_t ended_before = events.of_removed.size();
  parallel::select(
      executor, count, kCachedGrain, counts, [&](std::size_t i) { return is_of_removed(i) && cache.pairs[i].touching; },
      [&](std::size_t ended) { events.of_removed.resize(ended_before + ended); },
      [&](std::size_t i, std::size_t position) {
        events.of_removed[ended_before + position] = {ContactEvent::Kind::End, body_of(cache.pairs[i].low),
                                                      body_of(cache.pairs[i].high)};
      });
  // Nobody reads the pairs of the step before the last any more.
  CachedPairList& left = cache.previous_pairs;
  parallel::reserve_anew(left, cache.pairs.capacity());
  parallel::select(
      executor, count, kCachedGrain, counts, [&](std::size_t i) { return !is_of_removed(i); },
      [&](std::size_t kept) { left.resize(kept); },
      [&](std::size_t i, std::size_t position) { left[position] = cache.pairs[i]; });
  std::swap(cache.pairs, left);
  removed.clear();
}

// What is cached of a body that the caller has moved no longer holds.
void forget_displaced(BodyChanges& changes, ContactCache& cache, parallel::Executor& executor) {
  std::vector<std::uint32_t>& displaced = changes.displaced;
  if (displaced.empty()) return;
  std::sort(displaced.begin(), displaced.end());
  const auto is_displaced = [&](std::uint32_t slot) {
    return std::binary_search(displaced.begin(), displaced.end(), slot);
  };
  parallel::for_ranges(executor, {cache.pairs.size(), kCachedGrain},
                       [&](std::size_t, std::size_t begin, std::size_t end) {
                         for (std::size_t i = begin; i < end; ++i) {
                           CachedPair& pair = cache.pairs[i];
                           if (!is_displaced(pair.low) && !is_displaced(pair.high)) continue;
                           pair.reach_m = 0;
                           pair.apart = false;
                         }
                       });
  displaced.clear();
}

RefineInput refine_input(const WorldState& world, const StepInput& input, const StepTerms& terms, std::uint64_t number,
                         SteadyClock::time_point begun) {
  const WorldSettings& settings = world.settings;
  const Frame& frame = world.outputs;
  return {world.scene(),
          terms,
          frame.motion,
          frame.table,
          settings.policy,
          input,
          number,
          settings.seed,
          settings.substeps,
          settings.max_front_entries,
          begun,
          settings.islands_wait,
          frame.candidates.pairs};
}

parallel::Executor& executor_of(WorldState& world, SlicedStep* sliced) {
  return sliced != nullptr ? sliced->task.executor() : *world.executor;
}

// The stages of one step. Invariant: a function is given as const what it must not change.
class Step {
 public:
  // `number`: of the frame in which it begins. With `sliced` it is one in slices, on their thread.
  Step(WorldState& world, const StepInput& input, std::uint64_t number, FrameReport& report, SlicedStep* sliced)
      : world_(world),
        input_(input),
        number_(number),
        report_(report),
        terms_(terms_of(world.settings, input)),
        executor_(executor_of(world, sliced)),
        sliced_(sliced),
        frame_(world.outputs),
        laps_(executor_, report.started) {
    if (sliced_ != nullptr) sliced_->stages = &report.times;
  }

  void run() {
    crowded_partners_ = crowded_partners();
    resumed_ = begin_paused(sliced_ != nullptr ? sliced_->input : input_, world_.settings, world_.steps(),
                            world_.forecasts, world_.sleep_access(), executor_);
    if (in_use(world_.sleep_access())) wake_near_changes(world_.sleep_access(), executor_);
    forget_removed(world_.bodies, world_.body_changes, world_.cache, world_.events, executor_);
    forget_displaced(world_.body_changes, world_.cache, executor_);
    // What sleeps and has a moving body near it wakes, so that none is met as if it were static.
    do {
      find_pairs();
    } while (in_use(world_.sleep_access()) && wake_touched(frame_.table, world_.sleep_access(), executor_));
    report_.times.coarse += laps_.lap();
    report_.refine_started = laps_.at();
    refine_pairs();
    SolveInput solved = solve_input();
    make_manifolds(
        {world_.scene(), terms_, frame_.motion, frame_.table, frame_.levels, solver::still_mps(solved.settings())},
        world_.cache.points, frame_.manifolds, report_, executor_);
    report_.times.manifolds = laps_.lap();
    solved.memory = &frame_.levels.found.reuse_points();
    solve(solved);
    report_.times.solve = laps_.lap();
    if (sliced_ != nullptr) hide_end(world_, *sliced_);
    integrate({frame_.motion, frame_.velocities, terms_.dt_s}, world_.bodies, frame_.motions, executor_);
    report_out_of_range();
    report_.times.integrate = laps_.lap();
    PublishInput published = publish_input(world_);
    published.persist_events = input_.persist_events;
    publish(published, world_.cache, world_.events, frame_.publication, executor_);
  }
  // After what may rest.
  void end() {
    ++world_.contacts_version;
    // One that ends outside of a frame ends the one before.
    if (sliced_ == nullptr || sliced_->frame != nullptr) {
      ++world_.frame;
    } else {
      --world_.frames_without_step;
    }
    world_.frames_unfinished = 0;
    report_.times.publish = laps_.lap();
  }

  [[nodiscard]] FrameCounts counts() const {
    return {terms_.contact,
            world_.bodies.dynamic_count(),
            world_.settings.substeps,
            frame_.table,
            frame_.levels,
            frame_.manifolds.held_found,
            scheduler::leaves_out(world_.settings.policy)};
  }

 private:
  void find_pairs() {
    const SceneView scene = world_.scene();
    predict({scene, terms_}, frame_.motion, executor_);
    report_.times.predict += laps_.lap();
    const CrowdedByVolume crowds(world_.bodies);
    find_candidates({scene,
                     frame_.motion,
                     {world_.settings.max_partners, world_.settings.max_pairs,
                      crowded_partners_ > 0 ? &crowds : nullptr, crowded_partners_}},
                    world_.broad_phase, frame_.candidates, executor_);
    report_.times.broad_phase += laps_.lap();
    find_active_pairs({scene, terms_, frame_.motion, frame_.candidates, world_.cache.pairs, world_.pair_filter},
                      frame_.table, world_.pools, executor_);
    report_.pairs_discarded = frame_.candidates.discarded;
    report_.candidate_pairs = frame_.candidates.pairs.size();
    report_.work_mandatory += frame_.candidates.pairs.size();
    report_.coarse_pairs = frame_.table.near_count();
    report_.swept_pairs = frame_.table.swept.size();
    report_.times.coarse += laps_.lap();
  }

  // As many as there is time for, or as another run decided.
  [[nodiscard]] std::uint32_t crowded_partners() const {
    if (input_.replay != nullptr) return input_.replay->crowded_partners;
    return crowded_partners_in_time(input_, world_.bodies.dynamic_count(), world_.settings.max_partners,
                                    report_.started, world_.forecasts);
  }

  void refine_pairs() {
    DecisionLog* log = nullptr;
    if (input_.record && input_.replay == nullptr) {
      if (!world_.decisions) world_.decisions = std::make_unique<DecisionLog>();
      log = world_.decisions.get();
    }
    RefineInput input = refine_input(world_, input_, terms_, number_, laps_.at());
    if (sliced_ != nullptr) {
      input.step_begun = sliced_->begun;
      input.slice = sliced_->slice - sliced_->task.lead();
    }
    refine(input,
           {world_.pools, world_.forecasts, world_.bands, world_.rounds, world_.open, world_.learned,
            world_.prepared_cues, world_.cache.points, log},
           frame_.levels, report_, executor_);
    report_.degraded.bodies_paused = world_.bodies.paused_count();
    report_.degraded.bodies_held += report_.degraded.bodies_paused;
    if (resumed_ && log != nullptr) log->resumed();
    if (log != nullptr) log->crowded_partners(crowded_partners_);
    if (frame_.candidates.discarded > 0) report_.degraded.crowded_partners = crowded_partners_;
    report_.times.refine = laps_.lap();
  }

  // Substeps of this frame.
  [[nodiscard]] int substeps() const {
    return frame_.levels.substeps > 0 ? frame_.levels.substeps : world_.settings.substeps;
  }

  [[nodiscard]] SolveInput solve_input() const {
    return {world_.scene(), terms_, frame_.motion, frame_.table, frame_.levels, frame_.manifolds, world_.pools,
            substeps(),     {}};
  }

  void solve(const SolveInput& input) {
    PointCache& points = world_.cache.points;
    begin_solve(input, frame_.velocities, executor_);
    solve_impacts(input, points, frame_.velocities, report_, executor_);
    const IterationsAllowed allowed = iterations_allowed();
    const solver::Convergence ended =
        solve_contacts(input, allowed, points, world_.contact_solver, frame_.velocities, executor_);
    note_iterations(input, allowed, ended);
    if (!terms_.backtracking) return;
    if (!world_.swept_pool)
      world_.swept_pool = std::make_unique<collision::FrontPool>(world_.settings.max_front_entries);
    solve_swept(input, frame_.velocities, *world_.swept_pool, report_, executor_);
  }

  void report_out_of_range() {
    const std::vector<std::uint32_t>& slots = frame_.motions.out_of_range;
    if (slots.empty()) return;
    report_.out_of_range = slots.size();
    report_.out_of_range_body = world_.bodies.id_of(slots.front());
    forget_contacts_of(slots, frame_.table, frame_.manifolds, world_.cache.points, frame_.velocities);
  }

  // How many iterations resting contact may make: as many as the solver makes by itself, or before a deadline as many
  // as there is time for, or as another run decided.
  [[nodiscard]] IterationsAllowed iterations_allowed() {
    IterationsAllowed allowed;
    if (input_.replay != nullptr) {
      if (input_.replay->point_iterations > 0) allowed.most = input_.replay->point_iterations;
      allowed.repeated = input_.replay->stopped_after;
    } else if (input_.budget.kind == Budget::Kind::Deadline) {
      const SteadyClock::time_point deadline = frame_.levels.deadline;
      allowed.most = iterations_in_time(world_.forecasts, deadline, counts(), executor_.time(),
                                        frame_.velocities.point_count, report_);
      allowed.until = iterations_end(world_.forecasts, deadline, counts(), report_);
    }
    return allowed;
  }

  void note_iterations(const SolveInput& input, const IterationsAllowed& allowed, const solver::Convergence& ended) {
    report_.point_iterations = ended.point_iterations;
    if (ended.cut_short) {
      const std::uint64_t made = ended.point_iterations / static_cast<std::uint64_t>(input.substeps);
      report_.degraded.point_iterations = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(made, 1, allowed.most));
    }
    if (!allowed.until) return;
    const solver::IterationsMade& made = world_.contact_solver.made();
    world_.forecasts.times.iterated = made.beyond;
    world_.forecasts.times.iterations_end = made.ended;
    if (!input_.record) return;
    world_.decisions->point_iterations(allowed.most < solver::kMaxPointIterations ? allowed.most : 0);
    world_.decisions->stopped_after(made.stopped_after);
  }

  WorldState& world_;
  const StepInput& input_;
  const std::uint64_t number_;
  FrameReport& report_;
  StepTerms terms_;
  parallel::Executor& executor_;
  SlicedStep* sliced_;  // or null
  Frame& frame_;
  Laps laps_;
  std::uint32_t crowded_partners_ = 0;  // that each body in a crowd may have; 0: as in the settings
  bool resumed_ = false;                // all that was paused takes part again
};

}  // namespace

PublishInput publish_input(const WorldState& world) {
  const Frame& frame = world.outputs;
  return {world.scene(), world.settings.contact, frame.motion,     frame.table,
          frame.levels,  frame.manifolds,        frame.velocities, frame.motions};
}

void rest_after(WorldState& world, const StepInput& input, FrameReport& report, SlicedStep* sliced) {
  const Frame& frame = world.outputs;
  const StepTerms terms = terms_of(world.settings, input);
  parallel::Executor& executor = executor_of(world, sliced);
  if (world.settings.sleeping) {
    fall_asleep({frame.motion, frame.table, frame.motions, input.dt_s, terms.gravity_mps2.norm()}, world.sleep_access(),
                report, executor);
  }
  DecisionLog* log = input.record && input.replay == nullptr ? world.decisions.get() : nullptr;
  const RefineInput of_frame = refine_input(world, input, terms, report.frame, report.refine_started);
  const PauseResources resources{world.outputs.levels, world.sleep_access(), world.forecasts, world.steps(), log};
  if (input.replay != nullptr) {
    if (!pause_as_recorded(of_frame, input.replay->paused, resources, executor))
      report.status = StepStatus::ReplayDiffers;
    return;
  }
  if (input.budget.kind != Budget::Kind::Deadline || !Islands::any_may_wait(of_frame)) return;
  reserve_sets(resources.access, executor);
  if (sliced == nullptr && report.degraded.bodies_held == 0 && !report.infeasible_forecast) return;
  const Nanoseconds of_a_frame =
      sliced != nullptr ? sliced->slice : input.budget.deadline - report.started - report.host_reserved;
  IslandTurns turns(of_frame, resources, executor);
  if (turns.find(static_cast<double>(of_a_frame.count()), sliced != nullptr)) turns.deal();
}

FrameReport run_frame(WorldState& world, const StepInput& input, bool may_rest, SlicedStep* sliced) {
  parallel::Executor& executor = executor_of(world, sliced);
  const SteadyClock::time_point start = executor.time();
  FrameReport report;
  const Nanoseconds cpu_before = parallel::thread_cpu_time();
  const parallel::Waits waits_before = executor.waits();
  executor.wake();
  report.frame = world.frame;
  report.started = start;
  if (input.release) report.release_delay = std::max(Nanoseconds(0), start - *input.release);
  report.bodies = world.bodies.dynamic_count() + world.bodies.asleep_count();
  begin_frame_time(input, world.bodies.dynamic_count(), world.settings.substeps, start, world.forecasts, report);
  Step step(world, input, world.frame - world.frames_unfinished, report, sliced);
  step.run();
  if (may_rest) rest_after(world, input, report, sliced);
  step.end();
  report.times.total = executor.time() - start;
  // After the last stage: the clock of the CPU takes as long as a small stage.
  if (input.budget.kind == Budget::Kind::Deadline) {
    const CallerTime caller{parallel::thread_cpu_time() - cpu_before,
                            executor.waits() - waits_before - world.outputs.levels.waits};
    account_time(input, step.counts(), world.outputs.velocities.point_count, caller, world.forecasts, report);
  }
  return report;
}

}  // namespace poise::simulation
