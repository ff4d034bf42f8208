// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <time.h>

#include <functional>
#include <memory>
#include <thread>

#include "frame/budget/frame_time.h"
#include "frame/scenes.h"
#include "parallel/busy_thread.h"
#include "parallel/cpu_clock.h"
#include "verify/world_access.h"

// Each test disturbs a frame, and the report must name the cause. Durations are measured, never assumed, and frames are
// made late by CPU time of this thread alone, so the tests depend neither on the speed of the machine nor on other
// load.
namespace poise {
namespace {

using parallel::thread_cpu_time;
using simulation::WorldState;
using std::chrono::milliseconds;

// Runs on one thread, whatever its concurrency says; calls back at points where a test can disturb a frame.
class Injector final : public parallel::Executor {
 public:
  using Action = std::function<void()>;
  Action at_start, in_refinement, in_tail;
  mutable Action in_piece;  // of refinement

  [[nodiscard]] int concurrency() const override { return 2; }
  void wake() override {
    refined_ = false;
    call(at_start);
  }
  void run(parallel::WorkerFunction step) override {
    if (refined_) call(in_tail);
    work_off(step);
  }
  std::size_t run_with(const parallel::Patience&, parallel::WorkerFunction step) override {
    call(in_refinement);
    looks_ = 0;
    work_off(step);
    refined_ = true;
    return 0;
  }
  // A job looks at the clock where it begins, and then after each piece.
  [[nodiscard]] SteadyClock::time_point time() const override {
    if (++looks_ == 2) call(in_piece);
    return SteadyClock::now();
  }
  [[nodiscard]] bool commit(int) override { return true; }
  void settle() override {}

 private:
  static void work_off(parallel::WorkerFunction& step) {
    while (step(0)) {
    }
  }
  static void call(Action& action) {
    // Acts once a frame.
    Action once;
    std::swap(once, action);
    if (once) once();
  }
  bool refined_ = false;
  mutable int looks_ = 0;  // since refinement began
};

// Time that passed for this thread, and the part in which it did not run.
class Watch {
 public:
  [[nodiscard]] Nanoseconds wall() const { return SteadyClock::now() - begun_; }
  [[nodiscard]] Nanoseconds cpu() const { return thread_cpu_time() - cpu_; }
  [[nodiscard]] Nanoseconds stolen() const { return std::max(Nanoseconds(0), wall() - cpu()); }

 private:
  Nanoseconds cpu_ = thread_cpu_time();
  SteadyClock::time_point begun_ = SteadyClock::now();
};

template <class Done>
void spin_until(Done&& done) {
  while (!done()) {
  }
}

class MissCauses : public ::testing::Test {
 protected:
  MissCauses() : stage(settings(), 0.2) {
    stage.jacks(150, 5);
    WorldState& world = simulation::WorldAccess::of(stage.world);
    auto made = std::make_unique<Injector>();
    injector = made.get();
    // Some frames, so that there are pairs.
    for (int i = 0; i < 60; ++i) stage.world.step(step_of(1.0 / 60));
    world.executor = std::move(made);
    step_within(std::chrono::minutes(1));
  }
  static WorldSettings settings() {
    WorldSettings settings;
    settings.gravity_mps2 = Vec3(0, 0, -9.81);
    settings.executor = ExecutorKind::Serial;
    settings.threads = 1;
    return settings;
  }
  // Sets forecasts that fit into a frame, whatever earlier frames took.
  void expect_tail_of(Nanoseconds time) {
    scheduler::TimePriors priors;
    priors.frames = 1000;
    priors.log_quantile = 0;
    priors.spread = 0.1;
    priors.tail_us[0] = static_cast<double>(time.count()) / 1e3;
    stage.world.set_time_priors(priors);
  }
  FrameReport step_within(Nanoseconds budget) {
    StepInput input = step_of(1.0 / 60);
    deadline = SteadyClock::now() + budget;
    input.budget = Budget::until(deadline);
    watch = Watch();
    return stage.world.step(input);
  }
  [[nodiscard]] Nanoseconds late() const { return SteadyClock::now() - deadline; }

  Stage stage;
  Injector* injector = nullptr;
  SteadyClock::time_point deadline;
  Watch watch;
};

TEST_F(MissCauses, ASleepThatNobodyAskedForIsTheMachines) {
  injector->at_start = [&] {
    const auto until = std::chrono::duration_cast<Nanoseconds>((deadline + milliseconds(1)).time_since_epoch()).count();
    const timespec when{static_cast<time_t>(until / 1'000'000'000), static_cast<long>(until % 1'000'000'000)};
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr) != 0) {
    }
  };
  const FrameReport report = step_within(milliseconds(80));
  EXPECT_GT(report.lateness.count(), 0);
  EXPECT_EQ(report.cause, MissCause::Machine);
  EXPECT_GE(report.off_cpu, milliseconds(40));
  EXPECT_LT(report.mandatory, report.budget);
}

TEST_F(MissCauses, AMandatoryPartThatNeedsMoreThanThereIsMakesAFrameInfeasible) {
  injector->at_start = [&] { spin_until([&] { return watch.cpu() > milliseconds(21) && late().count() > 0; }); };
  const FrameReport report = step_within(milliseconds(20));
  EXPECT_EQ(report.cause, MissCause::Infeasible);
  EXPECT_GT(report.mandatory, report.budget);
  EXPECT_TRUE(report.infeasible_forecast) << "nothing was left when the pairs were found";
  EXPECT_EQ(report.jobs_done, 0U);
}

TEST_F(MissCauses, ASpinWithinRefinementIsAnOverrun) {
  for (int attempt = 0; attempt < 10; ++attempt) {
    expect_tail_of(milliseconds(20));
    // Later than other programs can cause: by 10 ms of this thread's own CPU time.
    injector->in_refinement = [&] { spin_until([&] { return watch.cpu() > milliseconds(40); }); };
    const FrameReport report = step_within(milliseconds(30));
    if (report.tail_actual > report.reserve_at_cut) continue;  // other programs disturbed the tail
    // Of 40 ms of its own, 10 ms at most were before the cut; how much more others took meanwhile is not in its hands.
    EXPECT_GE(report.longest_overrun, milliseconds(25));
    EXPECT_GE(report.longest_overrun + report.overrun_off_cpu, report.lateness);
    const bool mostly_taken = report.overrun_off_cpu > report.longest_overrun;
    EXPECT_EQ(report.cause, mostly_taken ? MissCause::Machine : MissCause::Overrun);
    EXPECT_LT(report.mandatory, report.budget);
    return;
  }
  FAIL() << "ten times in a row somebody had the processor for 20 ms in the response of a small scene";
}

TEST_F(MissCauses, ASpinInTheResponseBreaksTheForecast) {
  expect_tail_of(milliseconds(2));
  // Refinement uses the available time, so that the mandatory part is small.
  injector->in_refinement = [&] { spin_until([&] { return late() > milliseconds(-6); }); };
  bool spun = false;
  injector->in_tail = [&] {
    spun = true;
    spin_until([&] { return watch.cpu() > milliseconds(25); });
  };
  const FrameReport report = step_within(milliseconds(20));
  ASSERT_TRUE(spun) << "the scene is too small to have work for two threads after refinement";
  EXPECT_EQ(report.cause, MissCause::Forecast);
  EXPECT_GT(report.tail_actual, report.reserve_at_cut);
  EXPECT_LT(report.mandatory, report.budget);
}

TEST_F(MissCauses, AStolenCoreIsTheMachines) {
  const std::vector<int> processors = parallel::allowed_processors();
  if (processors.empty()) GTEST_SKIP() << "the system does not tell its processors";
  const parallel::OnProcessor here(processors.front());
  if (!here.settled()) GTEST_SKIP() << "the system does not let a thread choose its processor";
  // Several, so that well over half of the processor is taken even beside other programs.
  const parallel::BusyThread thieves[] = {parallel::BusyThread(processors.front()),
                                          parallel::BusyThread(processors.front()),
                                          parallel::BusyThread(processors.front())};
  injector->at_start = [&] {
    spin_until([&] {
      return (late().count() > 0 && watch.stolen() > late() + milliseconds(20)) ||
             watch.wall() > std::chrono::seconds(5);
    });
  };
  const FrameReport report = step_within(milliseconds(80));
  EXPECT_GT(report.lateness.count(), 0);
  EXPECT_EQ(report.cause, MissCause::Machine);
  EXPECT_GE(report.off_cpu, report.lateness);
  EXPECT_LT(report.mandatory, report.budget);
}

TEST_F(MissCauses, AFrameWhoseReleaseIsLongPastIsNotToBlame) {
  StepInput input = step_of(1.0 / 60);
  const SteadyClock::time_point now = SteadyClock::now();
  input.budget = Budget::until(now);
  input.release = now - std::chrono::hours(1);
  const FrameReport report = stage.world.step(input);
  EXPECT_GT(report.lateness.count(), 0);
  EXPECT_GE(report.release_delay, std::chrono::hours(1));
  EXPECT_EQ(report.cause, MissCause::Release);

  input.budget = Budget::until(SteadyClock::now());
  input.release = SteadyClock::time_point::max();
  const FrameReport punctual = stage.world.step(input);
  EXPECT_EQ(punctual.release_delay.count(), 0);
  EXPECT_NE(punctual.cause, MissCause::Release);

  input.release = SteadyClock::time_point::min();
  EXPECT_LE(stage.world.step(input).release_delay, kFarthestTime + std::chrono::hours(1));
}

// Its preemption is simulated by a sleep.
TEST_F(MissCauses, APieceOfRefinementThatTheMachineHeldUpIsNoOverrun) {
  expect_tail_of(milliseconds(20));
  injector->in_refinement = [&] {
    const auto until = std::chrono::duration_cast<Nanoseconds>((deadline + milliseconds(1)).time_since_epoch()).count();
    const timespec when{static_cast<time_t>(until / 1'000'000'000), static_cast<long>(until % 1'000'000'000)};
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr) != 0) {
    }
  };
  const FrameReport report = step_within(milliseconds(80));
  EXPECT_GT(report.lateness.count(), 0);
  EXPECT_EQ(report.cause, MissCause::Machine);
  EXPECT_GT(report.overrun_off_cpu, report.longest_overrun);
}

TEST_F(MissCauses, TheLongestPieceIsWithoutWhatTheMachineTook) {
  injector->in_piece = [] { std::this_thread::sleep_for(milliseconds(20)); };
  const FrameReport slept = step_within(std::chrono::minutes(1));
  EXPECT_GE(slept.overrun_off_cpu, milliseconds(19));
  EXPECT_GT(slept.longest_job.count(), 0);
  EXPECT_LT(slept.longest_job, slept.overrun_off_cpu);

  injector->in_piece = [] {
    const Watch own;
    spin_until([&] { return own.cpu() > milliseconds(20); });
  };
  EXPECT_GE(step_within(std::chrono::minutes(1)).longest_job, milliseconds(19));
}

TEST(HostWork, AFrameIsJudgedAnewByWhatTheHostTook) {
  FrameReport report;
  report.times.total = milliseconds(8);
  report.budget = milliseconds(16);
  report.host_reserved = milliseconds(4);
  report.mandatory = milliseconds(3) + report.host_reserved;
  simulation::add_host_work(milliseconds(5), Nanoseconds(0), report);
  EXPECT_EQ(report.cause, MissCause::None);
  EXPECT_EQ(report.mandatory, milliseconds(8));
  EXPECT_EQ(report.host_actual, milliseconds(5));

  // Longer than the reserve: the forecast was wrong.
  FrameReport late = report;
  late.host_reserved = report.host_actual;
  simulation::add_host_work(milliseconds(10), Nanoseconds(0), late);
  EXPECT_EQ(late.lateness, milliseconds(2));
  EXPECT_EQ(late.cause, MissCause::Forecast);

  FrameReport stolen = report;
  stolen.host_reserved = report.host_actual;
  simulation::add_host_work(milliseconds(10), milliseconds(6), stolen);
  EXPECT_EQ(stolen.cause, MissCause::Machine);

  FrameReport heavy = report;
  heavy.host_reserved = report.host_actual;
  simulation::add_host_work(milliseconds(20), Nanoseconds(0), heavy);
  EXPECT_EQ(heavy.cause, MissCause::Infeasible);
}

}  // namespace
}  // namespace poise
