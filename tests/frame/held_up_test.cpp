// SPDX-License-Identifier: MIT
// A suspended worker costs accuracy, not deadlines: a worker is stopped in the middle of a job until long after the
// frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "frame/refine/open_refinement.h"
#include "frame/scenes.h"
#include "frame/world_state.h"
#include "geometry/meshes.h"

namespace poise::simulation {

struct WorldAccess {
  static WorldState& of(World& world) { return *world.state_; }
};

namespace {

enum class Stopped : std::uint8_t {
  AtTheEnd,       ///< of its first refinement job, before it may publish it
  AtTheBeginning  ///< of that job, which is all that is refined; its clock stands still
};

/// Two threads, of which worker 1 is stopped.
class HoldsUpWorkerOne final : public parallel::Executor {
 public:
  HoldsUpWorkerOne(ExecutorKind kind, Stopped stopped)
      : at_the_end_(stopped == Stopped::AtTheEnd), inner_(parallel::make_executor(kind, 2)) {}
  [[nodiscard]] int concurrency() const override { return inner_->concurrency(); }
  void run(parallel::WorkerFunction step) override { inner_->run(step); }
  std::size_t run_with(const parallel::Patience& patience, parallel::WorkerFunction step) override {
    inner_->settle();  // before its function is replaced
    step_ = step;
    held_ = false;
    let_go_ = false;
    begun_ = inner_->time();
    refining_ = true;
    const std::size_t abandoned = inner_->run_with(patience, waiting_);
    refining_ = false;
    return abandoned;
  }
  [[nodiscard]] bool commit(int worker) override {
    if (worker == 1 && refining_ && at_the_end_) hold();
    return inner_->commit(worker);
  }
  void settle() override { inner_->settle(); }
  void wake() override { inner_->wake(); }
  [[nodiscard]] std::chrono::steady_clock::time_point time() const override {
    return std::this_thread::get_id() == stopped_.load() ? begun_ : inner_->time();
  }
  void let_go() { let_go_.store(true, order_); }
  [[nodiscard]] bool has_let_go() const { return let_go_.load(order_); }

 private:
  // At the beginning, what the other thread has written by then is not handed over: the thread sanitizer sees who
  // reads it.
  void hold() {
    held_ = true;
    while (!let_go_.load(order_)) std::this_thread::yield();
  }
  bool step(int worker) {
    // The calling thread begins when the other one is stopped, so that that one certainly has a job.
    while (worker == 0 && !held_) std::this_thread::yield();
    if (at_the_end_) return step_(worker);
    if (worker == 0) return false;
    stopped_ = std::this_thread::get_id();
    hold();
    const bool more = step_(worker);
    stopped_ = std::thread::id();
    return more;
  }
  struct Waiting {
    HoldsUpWorkerOne* owner;
    bool operator()(int worker) const { return owner->step(worker); }
  };

  const bool at_the_end_;
  const std::memory_order order_ = at_the_end_ ? std::memory_order_seq_cst : std::memory_order_relaxed;
  std::atomic<bool> held_{false}, let_go_{false}, refining_{false};
  std::atomic<std::thread::id> stopped_;  // the one whose clock stands still
  std::chrono::steady_clock::time_point begun_;
  parallel::WorkerFunction step_;
  Waiting waiting_{this};
  std::unique_ptr<parallel::Executor> inner_;  // last member: its threads end before the members that they read are
                                               // destroyed
};

class HeldUp : public testing::TestWithParam<ExecutorKind> {};
std::string kind_name(const testing::TestParamInfo<ExecutorKind>& kind) {
  return kind.param == ExecutorKind::Tbb ? "Tbb" : "Threads";
}
INSTANTIATE_TEST_SUITE_P(Kinds, HeldUp, testing::Values(ExecutorKind::Tbb, ExecutorKind::Threads), kind_name);

TEST_P(HeldUp, WorkerCostsItsJobAndTheFrameEndsWithoutIt) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = GetParam();
  settings.threads = 2;
  Stage stage(settings, 0.2);
  stage.jacks(60, 6);
  StepInput input = step_of(1.0 / 60);
  for (int i = 0; i < 30; ++i) stage.world.step(input);  // unlimited: the bodies have come to rest on each other
  WorldState& state = WorldAccess::of(stage.world);
  auto holding = std::make_unique<HoldsUpWorkerOne>(GetParam(), Stopped::AtTheEnd);
  HoldsUpWorkerOne& executor = *holding;
  state.executor = std::move(holding);
  std::size_t done = 0;
  for (int i = 0; i < 5; ++i) {
    // Shaken, so that no cached pair is valid and there is work to refine.
    for (const BodyId body : stage.bodies) {
      BodyState moved = stage.at(body);
      moved.velocity_mps.z() += 0.1;
      ASSERT_TRUE(stage.world.set_state(body, moved).ok());
    }
    input.budget = Budget::within(std::chrono::milliseconds(30));
    const FrameReport report = stage.world.step(input);
    ASSERT_EQ(report.jobs_abandoned, 1U);
    EXPECT_GE(report.jobs_discarded, 1U);
    done += report.jobs_done;
    EXPECT_GT(report.contact_pairs, 0U) << "what was not held up is answered";
    // The step is over and the worker is still in its job. Its result must have no effect.
    const std::uint64_t hash = stage.world.state_hash();
    const std::size_t contacts = stage.world.contacts().size();
    EXPECT_LE(contacts, report.contact_pairs);
    executor.let_go();
    state.settle();
    EXPECT_EQ(stage.world.state_hash(), hash);
    EXPECT_EQ(state.outputs.levels.tallies[1].jobs, 0U);
  }
  EXPECT_GT(done, 0U) << "the thread that was left refined alone";
}

TEST_P(HeldUp, WorkerIsWaitedForBeforeItsWorldIsChangedOrEnds) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = GetParam();
  settings.threads = 2;
  Stage stage(settings, 0.2);
  stage.jacks(40, 5);
  StepInput input = step_of(1.0 / 60);
  for (int i = 0; i < 20; ++i) stage.world.step(input);
  WorldState& state = WorldAccess::of(stage.world);
  auto holding = std::make_unique<HoldsUpWorkerOne>(GetParam(), Stopped::AtTheEnd);
  HoldsUpWorkerOne& executor = *holding;
  state.executor = std::move(holding);
  const auto held_step = [&] {
    input.budget = Budget::within(std::chrono::milliseconds(20));
    EXPECT_EQ(stage.world.step(input).jobs_abandoned, 1U);
    return std::jthread([&executor] {
      for (int i = 0; i < 3; ++i) std::this_thread::yield();
      executor.let_go();
    });
  };
  {
    const std::jthread later = held_step();
    stage.ball(0.3);  // an additional shape moves the array of shapes that the worker reads
  }
  {
    const std::jthread later = held_step();
    EXPECT_TRUE(stage.world.remove_body(stage.bodies.back()).ok());
    stage.bodies.pop_back();
  }
  // What else its scores are made of.
  {
    const std::jthread later = held_step();
    EXPECT_TRUE(stage.world.set_importance(stage.bodies.back(), 2).ok());
    EXPECT_TRUE(executor.has_let_go()) << "it was waited for";
  }
  {
    const std::jthread later = held_step();
    EXPECT_TRUE(stage.world.set_user_data(stage.bodies.back(), 7).ok());
    EXPECT_TRUE(executor.has_let_go()) << "it was waited for";
  }
  std::jthread later = held_step();
  { const World ended = std::move(stage.world); }
}

/// What the jobs of a refinement read depends on how pairs have their turns, and on the cues that are measured.
struct Turns {
  const char* name;
  bool in_order;  ///< of memory, not by score
  scheduler::Policy policy;
};
Turns with_all_cues(const char* name, bool in_order) {
  Turns all{name, in_order, {}};
  using scheduler::Policy;
  for (double Policy::*weight :
       {&Policy::occlusion, &Policy::gap, &Policy::delay, &Policy::onset, &Policy::crowding, &Policy::attention})
    all.policy.*weight = 1;
  all.policy.learning = 1;
  return all;
}

class HeldUpReader : public testing::TestWithParam<Turns> {};
INSTANTIATE_TEST_SUITE_P(Turns, HeldUpReader,
                         testing::Values(Turns{"ByScore", false, {}}, Turns{"InOrder", true, {}},
                                         with_all_cues("ByScoreOfAllCues", false),
                                         with_all_cues("InOrderWithAllCues", true)),
                         [](const testing::TestParamInfo<Turns>& turns) { return std::string(turns.param.name); });

// Under the thread sanitizer also that nothing is read that is written meanwhile.
TEST_P(HeldUpReader, FindsAllAsItWasWhenItBegan) {
  const auto step = [&](Stopped stopped) {
    WorldSettings settings;
    settings.gravity_mps2 = Vec3(0, 0, -9.81);
    settings.policy = GetParam().policy;
    settings.threads = 2;
    Stage stage(settings, 0.2);
    stage.tray(4);
    // By polygons, which are never so few that a pair goes on to them without a look at its score.
    const ShapeId box = stage.world.add_shape(
        make_mesh_shape(test::box_mesh(Vec3(0.6, 0.6, 0.6)), {.depth = 1, .preset = TreePreset::Fast}).value());
    for (int i = 0; i < 27; ++i)
      stage.add(box, Vec3(-1, -1, 0.5) + 0.9 * Vec3(i % 3, i / 3 % 3, i / 9), Vec3::Zero(), Vec3(0.1, 0.2, 0.1 * i));
    // Points of pairs on balls are changed where they are.
    const ShapeId ball = stage.ball(0.2);
    for (int i = 0; i < 9; ++i) stage.add(ball, Vec3(-1, -1, 3) + 0.9 * Vec3(i % 3, i / 3, 0));
    StepInput input = step_of(1.0 / 60);
    input.polygons = true;
    input.view = {true, Vec3(-12, 0, 4)};
    input.attention = {Vec3(0, 0, 1), 2.0, stage.bodies.front()};
    for (int i = 0; i < 32; ++i) stage.world.step(input);  // in the next one jobs look at the first pairs in order
    WorldState& state = WorldAccess::of(stage.world);
    if (GetParam().in_order) state.forecasts.pair_cost.learn(1, true);
    auto holding = std::make_unique<HoldsUpWorkerOne>(ExecutorKind::Threads, stopped);
    HoldsUpWorkerOne& executor = *holding;
    state.executor = std::move(holding);
    for (const BodyId body : stage.bodies) {
      BodyState moved = stage.at(body);
      moved.velocity_mps.z() += 0.1;
      moved.angular_velocity_radps += Vec3(0.1, 0.2, 0.3);
      EXPECT_TRUE(stage.world.set_state(body, moved).ok());
    }
    input.budget = Budget::within(std::chrono::milliseconds(250));
    EXPECT_EQ(stage.world.step(input).jobs_abandoned, 1U);
    executor.let_go();
    state.settle();
    EXPECT_EQ(state.open.chunks_in_order.has_value(), GetParam().in_order);
    const OpenRefinement::Batch& batch = state.open.batches[1];
    EXPECT_EQ(batch.looks, GetParam().in_order);
    return std::vector<OpenRefinement::Hand>(batch.hands.begin(), batch.hands.begin() + static_cast<long>(batch.count));
  };
  const std::vector<OpenRefinement::Hand> before = step(Stopped::AtTheEnd);
  const std::vector<OpenRefinement::Hand> after = step(Stopped::AtTheBeginning);
  ASSERT_FALSE(before.empty());
  // Other cues than those that are scored in lanes are kept.
  EXPECT_EQ(std::ranges::any_of(before, &OpenRefinement::Hand::has_cues),
            !GetParam().in_order && GetParam().policy.learning == 0);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const OpenRefinement::Hand &a = before[i], &b = after[i];
    EXPECT_EQ(b.item, a.item);
    EXPECT_EQ(b.progress.level.level, a.progress.level.level);
    EXPECT_EQ(b.found.contact.estimated_separation_m, a.found.contact.estimated_separation_m);
    EXPECT_EQ(b.progress.seen, a.progress.seen);
    EXPECT_EQ(b.again, a.again);
    EXPECT_EQ(b.band, a.band);
    ASSERT_EQ(b.has_cues, a.has_cues);
    if (a.has_cues) {
      EXPECT_EQ(b.cues.closing_mps, a.cues.closing_mps);
      EXPECT_EQ(b.cues.angle_radpm, a.cues.angle_radpm);
      EXPECT_EQ(b.cues.attended, a.cues.attended);
      EXPECT_EQ(b.cues.gap_rad, a.cues.gap_rad);
    }
  }
}

}  // namespace
}  // namespace poise::simulation
