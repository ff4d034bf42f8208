// SPDX-License-Identifier: MIT
#include "frame/budget/pause.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "frame/view_cues.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// Of a frame, in the forecast of what all islands want: they take turns if it is more than the first, and all take part
// again when it is less than the second. Chosen.
constexpr double kFull = 0.9, kAmple = 0.75;
// Of a frame, what is best seen has at most so much to itself. Chosen.
constexpr double kShareOfSeen = 0.5;
// Larger islands do not take turns: a frame that has one of them is late whether the others wait or not, and a heap
// that waits where it is looked at is refined meanwhile. Of a frame, and of all that there is. Chosen.
constexpr double kLargestOfFrame = 0.5, kLargestOfAll = 0.125;
// Of a step that takes several frames whoever waits: with those whose turn it is. Chosen.
constexpr double kLongerByTurns = 1.25;
// What comes near in so many steps takes its turn together. Chosen: what meets something paused wakes it, which costs
// more.
constexpr double kApartSteps = 4;

// Where there are only islands that are too large, they are looked for again after so many steps: that takes a
// twentieth of a step. Chosen.
constexpr int kStepsBetweenLooks = 3;

// Bodies that are paused, and islands that get their turns, one after another before the executor may stop; and those
// that are looked at in one item of a loop.
constexpr std::size_t kPauseGrain = 8192, kTurnGrain = 2048, kWakeGrain = 1024;

double frame_ns(const StepInput& step, SteadyClock::time_point started, Nanoseconds host) {
  return static_cast<double>(Nanoseconds(step.budget.deadline - started - host).count());
}

bool waits(const SleepingSet& set) { return !set.slots.empty() && set.wakes != SleepingSet::kNever; }

std::uint64_t load_of(const SleepingSet& set) {
  return std::accumulate(set.load.begin(), set.load.end(), std::uint64_t{0});
}

std::uint64_t paused_load(const SleepingState& sleep) {
  std::uint64_t load = 0;
  for (const SleepingSet& set : sleep.sets) load += waits(set) ? load_of(set) : 0;
  return load;
}

std::uint64_t load_of(const IslandSums::Island& island) { return std::uint64_t{island.bodies} + island.pairs; }

// Who is paused for how long.
class Turns {
 public:
  // `holds`: what a frame holds, as a load.
  Turns(const RefineInput& input, const Islands& islands, const PauseResources& resources, double holds)
      : input_(input), islands_(islands), holds_(holds) {
    const SleepingState& sleep = resources.access.sleeping;
    const std::uint64_t steps = resources.steps;
    for (const SleepingSet& set : sleep.sets) {
      if (!waits(set) || set.wakes <= steps) continue;
      due_[std::min<std::size_t>(set.wakes - steps, kMostTurnsUnseen)] += load_of(set);
      for (std::size_t k = 0; k < set.load.size(); ++k) loads_[k + 1] += static_cast<double>(set.load[k]);
    }
  }

  // Of islands in the order in which they wait. Fills `paused`.
  void deal(std::span<const std::uint32_t> waiting, std::uint64_t other_load, std::vector<PausedIsland>& paused,
            parallel::Executor& executor) {
    parallel::serial_for(executor, waiting.size(), kPauseGrain, [&](std::size_t begin, std::size_t end) {
      for (const std::uint32_t root : waiting.subspan(begin, end - begin)) loads_[longest(root)] += load(root);
    });
    // The best seen take part in every frame, as far as the others then still can in time. Without a viewer nobody is
    // better seen than others.
    double always = static_cast<double>(other_load);
    const double most_always = std::clamp(holds_ - of_frame(kMostTurnsUnseen), 0.0, kShareOfSeen * holds_);
    std::size_t taking_turns = waiting.size();
    while (input_.step.view.present && taking_turns > 0) {
      const std::uint32_t root = waiting[taking_turns - 1];
      if (islands_[root].angle_urad == 0 || always + load(root) > most_always) break;
      always += load(root);
      loads_[longest(root)] -= load(root);
      --taking_turns;
    }
    // As few turns as fit.
    std::size_t turns = 2;
    while (turns < kMostTurnsUnseen && always + of_frame(turns) > holds_) ++turns;
    parallel::serial_for(executor, taking_turns, kTurnGrain, [&](std::size_t begin, std::size_t end) {
      for (const std::uint32_t root : waiting.subspan(begin, end - begin)) {
        const std::size_t waited = std::min<std::size_t>(input_.scene.bodies.frames_held[root], kMostFramesHeld);
        give_turn(root, std::min(turns, longest(root) - waited), paused);
      }
    });
  }

 private:
  [[nodiscard]] double load(std::uint32_t root) const { return static_cast<double>(load_of(islands_[root])); }
  [[nodiscard]] std::size_t longest(std::uint32_t root) const {
    return most_turns(input_.step.view, islands_[root].angle_urad);
  }
  // What of all that takes turns is in one frame.
  [[nodiscard]] double of_frame(std::size_t turns) const {
    double sum = 0;
    for (std::size_t k = 1; k < loads_.size(); ++k) sum += loads_[k] / static_cast<double>(std::min(k, turns));
    return sum;
  }
  // In one of the next steps, `most` at most: that which has least to do, of those the last.
  void give_turn(std::uint32_t root, std::size_t most, std::vector<PausedIsland>& paused) {
    std::size_t best = most;
    for (std::size_t k = most; k >= 1; --k) {
      if (due_[k] < due_[best]) best = k;
    }
    due_[best] += load_of(islands_[root]);
    if (best > 1) paused.push_back({root, static_cast<std::uint32_t>(best - 1)});
  }

  const RefineInput& input_;
  const Islands& islands_;
  const double holds_;
  std::array<double, kMostTurnsUnseen + 1> loads_{};       // of what takes turns, by the most turns it may wait for
  std::array<std::uint64_t, kMostTurnsUnseen + 1> due_{};  // from the next step on: what takes part then
};

// A ball around each paused island that is out of view.
void note_unseen(const RefineInput& input, std::span<const PausedIsland> paused, const Islands& islands,
                 const PauseResources& resources) {
  if (!input.step.view.present) return;
  const SleepAccess& access = resources.access;
  const dynamics::BodyStore& bodies = access.bodies;
  SleepingState& sleep = access.sleeping;
  for (const PausedIsland& island : paused) {
    std::vector<SleepingSet::Unseen>& unseen = sleep.sets[sleep.set_of[island.root]].unseen;
    if (islands[island.root].angle_urad > 0) continue;
    islands[island.root].open = static_cast<std::uint32_t>(unseen.size());
    unseen.push_back({bodies.position(island.root), 0, 0, island.root, resources.steps});
  }
  for (const std::uint32_t slot : input.motion.visited) {
    if (bodies.paused[slot] == 0) continue;
    const std::uint32_t root = islands.root_of(slot);
    const IslandSums::Island& island = islands[root];
    if (island.steps_paused == 0 || island.angle_urad > 0) continue;
    SleepingSet::Unseen& ball = sleep.sets[sleep.set_of[root]].unseen[island.open];
    ball.body_radius_m = std::max(ball.body_radius_m, bodies.shape[slot]->bounding_radius_m);
    ball.radius_m =
        std::max(ball.radius_m, (bodies.position(slot) - ball.center_m).norm() + bodies.shape[slot]->bounding_radius_m);
  }
}

void apply(const RefineInput& input, std::span<const PausedIsland> paused, Islands& islands,
           const PauseResources& resources, parallel::Executor& executor) {
  if (paused.empty()) return;
  const SleepAccess& access = resources.access;
  SleepingState& sleep = access.sleeping;
  for (const PausedIsland& island : paused) {
    islands[island.root].steps_paused = static_cast<std::uint8_t>(island.steps);
    SleepingSet& set = sleep.sets[set_that_wakes(sleep, resources.steps + island.steps + 1)];
    if (set.slots.empty()) {
      set.load = {};
      set.unseen.clear();
    }
    set.load[most_turns(input.step.view, islands[island.root].angle_urad) - 1] += load_of(islands[island.root]);
    // Not empty, so that the next of its step finds it.
    add_to_set(sleep, static_cast<std::uint32_t>(&set - sleep.sets.data()), island.root, island.root);
    access.bodies.pause(island.root);
  }
  const std::span<const std::uint32_t> visited = input.motion.visited;
  parallel::serial_for(executor, visited.size(), kPauseGrain, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t slot : visited.subspan(begin, end - begin)) {
      if (access.bodies.dynamic[slot] == 0) continue;
      const std::uint32_t root = islands.root_of(slot);
      if (islands[root].steps_paused == 0) continue;
      add_to_set(sleep, sleep.set_of[root], slot, root);
      access.bodies.pause(slot);
    }
  });
  note_unseen(input, paused, islands, resources);
  executor.stop_point();
  take_pairs_of_sleepers(access, executor);
}

}  // namespace

bool begin_paused(const StepInput& step, const WorldSettings& settings, std::uint64_t steps, const Forecasts& forecasts,
                  const SleepAccess& access, parallel::Executor& executor) {
  SleepingState& sleep = access.sleeping;
  if (access.bodies.paused_count() == 0) return false;
  bool all =
      step.budget.kind != Budget::Kind::Deadline || step.backtracking || settings.islands_wait == IslandsWait::Never;
  if (step.replay != nullptr) {
    all = step.replay->resumed;
  } else if (!all) {
    const TimeFacts& times = forecasts.times;
    const double wanted_ns = times.ns_of_load * static_cast<double>(times.load + paused_load(sleep));
    all = wanted_ns <= kAmple * frame_ns(step, SteadyClock::now(), Nanoseconds(0));
  }
  parallel::Shared<int> any(0);
  const auto wake = [&](std::uint32_t slot) {
    parallel::raise(sleep.wake_requested[sleep.island[slot]]);
    if (any.get() == 0) any.set(1);
  };
  const ViewQuery view_query(step.view);
  for (const SleepingSet& set : sleep.sets) {
    if (!waits(set)) continue;
    if (all || set.wakes <= steps) {
      parallel::parallel_for(executor, set.slots.size(), kWakeGrain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k) wake(set.slots[k]);
      });
      continue;
    }
    parallel::parallel_for(executor, set.unseen.size(), kWakeGrain, [&](std::size_t begin, std::size_t end, int) {
      for (const SleepingSet::Unseen& ball : std::span(set.unseen).subspan(begin, end - begin)) {
        if (access.bodies.paused[ball.slot] == 0 || !in_frustum(view_query, ball.center_m, ball.radius_m)) continue;
        const std::size_t most =
            most_turns(step.view, visible_angle_urad(view_query, ball.center_m, ball.body_radius_m));
        if (most == kMostTurns || steps - ball.since >= most) wake(ball.slot);
      }
    });
  }
  sleep.any_wake_requested = sleep.any_wake_requested || any.get() != 0;
  return all;
}

bool pause_as_recorded(const RefineInput& input, std::span<const PausedIsland> recorded,
                       const PauseResources& resources, parallel::Executor& executor) {
  if (recorded.empty()) return true;
  if (!Islands::any_may_wait(input)) return false;
  reserve_sets(resources.access, executor);
  Islands islands(input, resources.levels.islands, executor);
  islands.find(resources.levels.progress, kApartSteps * input.terms.dt_s);
  islands.weigh_bodies();
  std::vector<PausedIsland> paused;
  for (const PausedIsland& island : recorded) {
    const bool there = island.root < input.scene.bodies.slot_count() && islands.may_wait(island.root);
    const bool again = !paused.empty() && island.root <= paused.back().root;
    if (there && !again && island.steps > 0 && island.steps <= kMostStepsUnseen) paused.push_back(island);
  }
  apply(input, paused, islands, resources, executor);
  return paused.size() == recorded.size();
}

bool IslandTurns::find(double frame_ns, bool in_slices) {
  const dynamics::BodyStore& bodies = input_.scene.bodies;
  SleepingState& sleep = resources_.access.sleeping;
  const double load_ns = resources_.forecasts.times.ns_of_load;
  const std::uint64_t awake_load = bodies.dynamic_count() + input_.table.size();
  const double wanted_ns = load_ns * static_cast<double>(awake_load + paused_load(sleep));
  if (load_ns <= 0 || wanted_ns <= kFull * frame_ns) return false;
  if (resources_.forecasts.times.no_turns > 0) {
    --resources_.forecasts.times.no_turns;
    return false;
  }
  islands_.emplace(input_, resources_.levels.islands, executor_);
  Islands& islands = *islands_;
  if (!islands.worth_a_look()) return false;
  islands.find(resources_.levels.progress, kApartSteps * input_.terms.dt_s);
  std::vector<std::uint32_t>& waiting = sleep.slots;
  waiting.clear();
  holds_ = std::max(0.0, kFull * frame_ns / load_ns);
  const double largest = std::max(kLargestOfFrame * holds_, kLargestOfAll * wanted_ns / load_ns);
  std::uint64_t load = 0;
  islands.for_each_that_may_wait([&](std::uint32_t root) {
    if (static_cast<double>(load_of(islands[root])) > largest) return;
    waiting.push_back(root);
    load += load_of(islands[root]);
  });
  other_load_ = awake_load - std::min(load, awake_load);
  if (in_slices) holds_ = std::max(holds_, kLongerByTurns * static_cast<double>(other_load_));
  if (waiting.empty()) {
    resources_.forecasts.times.no_turns = kStepsBetweenLooks;
    return false;
  }
  islands.weigh_bodies();
  islands.sort_by_turn(waiting);
  return true;
}

void IslandTurns::deal() {
  SleepingState& sleep = resources_.access.sleeping;
  std::vector<PausedIsland>& paused = sleep.islands_paused;
  paused.clear();
  Turns(input_, *islands_, resources_, holds_).deal(sleep.slots, other_load_, paused, executor_);
  parallel::sort(executor_, paused, sleep.islands_sorting,
                 [](const PausedIsland& x, const PausedIsland& y) { return x.root < y.root; });
  if (resources_.log != nullptr) resources_.log->paused(paused);
  apply(input_, paused, *islands_, resources_, executor_);
}

}  // namespace poise::simulation
