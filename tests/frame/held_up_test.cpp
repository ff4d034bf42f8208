// SPDX-License-Identifier: MIT
// A suspended worker costs accuracy, not deadlines: a worker is stopped in the middle of a job until long after the
// frame.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "frame/scenes.h"
#include "frame/world_state.h"

namespace poise::simulation {

struct WorldAccess {
  static WorldState& of(World& world) { return *world.state_; }
};

namespace {

/// Two threads; worker 1 is stopped at the end of its first refinement job, before it may publish it.
class HoldsUpWorkerOne final : public parallel::Executor {
 public:
  explicit HoldsUpWorkerOne(ExecutorKind kind) : inner_(parallel::make_executor(kind, 2)) {}
  [[nodiscard]] int concurrency() const override { return inner_->concurrency(); }
  void run(parallel::WorkerFunction step) override { inner_->run(step); }
  std::size_t run_with(const parallel::Patience& patience, parallel::WorkerFunction step) override {
    inner_->settle();  // before its function is replaced
    step_ = step;
    held_ = false;
    let_go_ = false;
    refining_ = true;
    const std::size_t abandoned = inner_->run_with(patience, waiting_);
    refining_ = false;
    return abandoned;
  }
  [[nodiscard]] bool commit(int worker) override {
    if (worker == 1 && refining_) {
      held_ = true;
      while (!let_go_) std::this_thread::yield();
    }
    return inner_->commit(worker);
  }
  void settle() override { inner_->settle(); }
  void wake() override { inner_->wake(); }
  void let_go() { let_go_ = true; }

 private:
  bool step(int worker) {
    // The calling thread begins when the other one is stopped, so that that one certainly has a job.
    while (worker == 0 && !held_) std::this_thread::yield();
    return step_(worker);
  }
  struct Waiting {
    HoldsUpWorkerOne* owner;
    bool operator()(int worker) const { return owner->step(worker); }
  };

  std::atomic<bool> held_{false}, let_go_{false}, refining_{false};
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
  auto holding = std::make_unique<HoldsUpWorkerOne>(GetParam());
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
  auto holding = std::make_unique<HoldsUpWorkerOne>(GetParam());
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
  std::jthread later = held_step();
  { const World ended = std::move(stage.world); }
}

}  // namespace
}  // namespace poise::simulation
