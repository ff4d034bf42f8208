// SPDX-License-Identifier: MIT
#include "poise/executor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "frame/scenes.h"
#include "parallel/executor.h"

namespace poise {
namespace {

/// A host's pool of threads with one queue.
class Pool final : public HostExecutor {
 public:
  explicit Pool(int threads) {
    for (int i = 1; i < threads; ++i) threads_.emplace_back([this] { work(); });
  }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  ~Pool() override {
    {
      const std::lock_guard<std::mutex> hold(lock_);
      stopping_ = true;
    }
    wake_.notify_all();
  }
  [[nodiscard]] int concurrency() const override { return static_cast<int>(threads_.size()) + 1; }
  int start(int count, const HostTask& task) override {
    asked += count;
    {
      const std::lock_guard<std::mutex> hold(lock_);
      for (int i = 0; i < count; ++i) queue_.push_back(task);
      most_pending = std::max(most_pending, queue_.size());
    }
    wake_.notify_all();
    return count;
  }
  std::atomic<int> asked{0};
  std::atomic<int> called{0};
  std::size_t most_pending = 0;

 private:
  void work() {
    for (;;) {
      HostTask task;
      {
        std::unique_lock<std::mutex> hold(lock_);
        wake_.wait(hold, [&] { return stopping_ || !queue_.empty(); });
        if (queue_.empty()) return;
        task = queue_.front();
        queue_.pop_front();
      }
      ++called;
      task();
    }
  }
  std::mutex lock_;
  std::condition_variable wake_;
  std::deque<HostTask> queue_;
  bool stopping_ = false;
  std::vector<std::jthread> threads_;
};

/// Accepts calls and makes them later, on the thread that asks for it, or refuses them.
class Lazy final : public HostExecutor {
 public:
  explicit Lazy(bool accepts) : accepts_(accepts) {}
  [[nodiscard]] int concurrency() const override { return 4; }
  int start(int count, const HostTask& task) override {
    asked += count;
    if (!accepts_) return 0;
    const std::lock_guard<std::mutex> hold(lock_);
    for (int i = 0; i < count; ++i) tasks_.push_back(task);
    return count;
  }
  std::size_t do_all() {
    std::vector<HostTask> tasks;
    {
      const std::lock_guard<std::mutex> hold(lock_);
      tasks.swap(tasks_);
    }
    for (const HostTask& task : tasks) task();
    return tasks.size();
  }
  std::atomic<int> asked{0};

 private:
  std::mutex lock_;
  bool accepts_;
  std::vector<HostTask> tasks_;
};

/// Makes the calls at once on the thread that asks.
class AtOnce final : public HostExecutor {
 public:
  [[nodiscard]] int concurrency() const override { return 3; }
  int start(int count, const HostTask& task) override {
    for (int i = 0; i < count; ++i) task();
    return count;
  }
};

WorldSettings settings_with(std::shared_ptr<HostExecutor> host) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = host ? ExecutorKind::Host : ExecutorKind::Serial;
  settings.host_executor = std::move(host);
  return settings;
}

std::uint64_t hash_after(const WorldSettings& settings, int frames, const std::function<void()>& between = {}) {
  Stage stage(settings);
  stage.jacks(120, 10);
  StepInput input;
  input.budget = Budget::work(20000);
  for (int frame = 0; frame < frames; ++frame) {
    EXPECT_EQ(stage.world.step(input).status, StepStatus::Done);
    if (between) between();
  }
  return stage.world.state_hash();
}

TEST(HostExecutor, GivesTheStateOfTheSerialOne) {
  const auto pool = std::make_shared<Pool>(4);
  EXPECT_EQ(hash_after(settings_with(pool), 40), hash_after(settings_with(nullptr), 40));
  EXPECT_GT(pool->called.load(), 0);
  // Calls that are pending or running are not asked for again.
  EXPECT_LE(pool->most_pending, 3U);
}

TEST(HostExecutor, MayStartNobody) {
  const auto nobody = std::make_shared<Lazy>(false);
  const auto never = std::make_shared<Lazy>(true);
  const std::uint64_t expected = hash_after(settings_with(nullptr), 20);
  EXPECT_EQ(hash_after(settings_with(nobody), 20), expected);
  EXPECT_GT(nobody->asked.load(), 3);
  EXPECT_EQ(hash_after(settings_with(never), 20), expected);
  EXPECT_EQ(never->asked.load(), 3);  // as many as there are other threads; they are still pending
  EXPECT_EQ(never->do_all(), 3U);     // when the World is destroyed
}

TEST(HostExecutor, MayStartThemLate) {
  const auto late = std::make_shared<Lazy>(true);
  std::size_t done = 0;
  const std::uint64_t hash = hash_after(settings_with(late), 20, [&] { done += late->do_all(); });
  EXPECT_EQ(hash, hash_after(settings_with(nullptr), 20));
  EXPECT_GE(done, 20U);
}

TEST(HostExecutor, MayStartThemOnAnotherThreadAtAnyTime) {
  const auto late = std::make_shared<Lazy>(true);
  std::atomic<bool> over{false};
  std::jthread other([&] {
    while (!over) late->do_all();
  });
  const std::uint64_t hash = hash_after(settings_with(late), 40);
  over = true;
  EXPECT_EQ(hash, hash_after(settings_with(nullptr), 40));
}

TEST(HostExecutor, MayCallTheTaskAtOnce) {
  EXPECT_EQ(hash_after(settings_with(std::make_shared<AtOnce>()), 5), hash_after(settings_with(nullptr), 5));
}

TEST(HostExecutor, RunsUnderADeadline) {
  const auto pool = std::make_shared<Pool>(4);
  Stage stage(settings_with(pool));
  stage.jacks(120, 10);
  StepInput input;
  for (int frame = 0; frame < 60; ++frame) {
    input.budget = Budget::within(std::chrono::milliseconds(2));
    const FrameReport report = stage.world.step(input);
    ASSERT_EQ(report.status, StepStatus::Done);
  }
  for (const BodyId body : stage.bodies) {
    const BodyState state = stage.world.state(body).value();
    ASSERT_TRUE(state.position_m.allFinite());
    EXPECT_GT(state.position_m.z(), -0.5);
  }
}

TEST(HostExecutor, ServesSeveralWorldsAtOnce) {
  const auto pool = std::make_shared<Pool>(3);
  const std::uint64_t expected = hash_after(settings_with(nullptr), 15);
  std::uint64_t one = 0;
  std::uint64_t two = 0;
  {
    std::jthread first([&] { one = hash_after(settings_with(pool), 15); });
    std::jthread second([&] { two = hash_after(settings_with(pool), 15); });
  }
  EXPECT_EQ(one, expected);
  EXPECT_EQ(two, expected);
}

TEST(HostExecutor, LendsAtMostWhatItOffers) {
  WorldSettings settings = settings_with(std::make_shared<Pool>(3));
  EXPECT_EQ(World::create(settings).value().threads(), 3);
  settings.threads = 2;
  EXPECT_EQ(World::create(settings).value().threads(), 2);
  settings.threads = 8;
  EXPECT_EQ(World::create(settings).value().threads(), 3);
}

TEST(HostExecutor, DoesEachItemOnce) {
  parallel::ExecutorSettings settings;
  settings.kind = ExecutorKind::Host;
  settings.host = std::make_shared<Pool>(4);
  const auto executor = std::move(parallel::make_executor(settings)).value();
  for (int round = 0; round < 200; ++round) {
    std::vector<std::atomic<int>> done(500);
    parallel::parallel_for(*executor, done.size(), 3, [&](std::size_t begin, std::size_t end, int worker) {
      ASSERT_LT(worker, 4);
      for (std::size_t i = begin; i < end; ++i) ++done[i];
    });
    for (const auto& count : done) ASSERT_EQ(count.load(), 1);
  }
}

TEST(HostExecutor, IsRefusedWhereItMakesNoSense) {
  struct Odd final : HostExecutor {
    explicit Odd(int n) : threads(n) {}
    [[nodiscard]] int concurrency() const override { return threads; }
    int start(int, const HostTask&) override { return 0; }
    int threads;
  };
  const auto refusal = [](const WorldSettings& settings) {
    const Result<World> world = World::create(settings);
    return world ? std::string() : world.error().message;
  };
  WorldSettings settings = settings_with(nullptr);
  settings.executor = ExecutorKind::Host;
  EXPECT_EQ(refusal(settings), "host_executor = null, must be given with the executor host");
  EXPECT_EQ(refusal(settings_with(std::make_shared<Odd>(0))), "host_executor: concurrency() = 0, must be in [1, 256]");
  EXPECT_EQ(refusal(settings_with(std::make_shared<Odd>(257))),
            "host_executor: concurrency() = 257, must be in [1, 256]");
  settings = settings_with(std::make_shared<Odd>(2));
  settings.realtime_priority = 1;
  EXPECT_NE(refusal(settings).find("realtime_priority: must be left out with the executor host"), std::string::npos);
  settings.realtime_priority = 0;
  settings.executor = ExecutorKind::Threads;
  EXPECT_EQ(refusal(settings), "host_executor: must be left out but with the executor host");
  EXPECT_EQ(refusal(settings_with(std::make_shared<Odd>(1))), "");
}

TEST(HostTask, ThatIsEmptyDoesNothing) {
  const HostTask none;
  none();
  SUCCEED();
}

}  // namespace
}  // namespace poise
