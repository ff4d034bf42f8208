// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <cstdint>
#include <ctime>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "parallel/executor.h"
#include "parallel/worker_gate.h"

namespace poise::parallel {

/// The two halves of WorkerGate::take_part, so that a test can act between them, as the system would.
struct WorkerGateAccess {
  static void raise(WorkerGate& gate, int worker) { WorkerGate::raise(gate.hands_[static_cast<std::size_t>(worker)]); }
  static bool may_begin(WorkerGate& gate, int worker) {
    std::uint64_t run = 0;
    return gate.look(gate.hands_[static_cast<std::size_t>(worker)], 0, run) == WorkerGate::GateState::Open;
  }
  static bool caller_sleeps(const WorkerGate& gate) { return gate.caller_sleeps_.load(); }
  static void leave(WorkerGate& gate, int worker) { gate.leave(gate.hands_[static_cast<std::size_t>(worker)]); }
};

namespace {

// Worker 1 takes an item and holds it until it is released; the calling thread ends its part after that.
struct HeldItem {
  Executor& executor;
  bool commit_first;
  std::atomic<bool> held{false}, go_on{false}, left{false};
  std::atomic<int> committed{-1};

  bool operator()(int worker) {
    if (worker == 0) {
      while (!held) std::this_thread::yield();
      return false;
    }
    if (held) return false;
    if (commit_first) committed = executor.commit(worker) ? 1 : 0;
    held = true;
    if (commit_first) {
      // The caller is about to wait or is waiting.
      for (int i = 0; i < 10; ++i) std::this_thread::yield();
    } else {
      while (!go_on) std::this_thread::yield();
      committed = executor.commit(worker) ? 1 : 0;
    }
    left = true;
    return false;
  }
};

class GiveUp : public testing::TestWithParam<ExecutorKind> {
 protected:
  std::unique_ptr<Executor> executor_ = make_executor(GetParam(), 2);
};

std::string kind_name(const testing::TestParamInfo<ExecutorKind>& kind) {
  return kind.param == ExecutorKind::Tbb ? "Tbb" : "Threads";
}
INSTANTIATE_TEST_SUITE_P(Kinds, GiveUp, testing::Values(ExecutorKind::Tbb, ExecutorKind::Threads), kind_name);

TEST_P(GiveUp, LeavesBehindWhatAHeldUpWorkerHasInHandAndRefusesItsCommit) {
  for (int round = 0; round < 8; ++round) {
    HeldItem item{*executor_, false};
    EXPECT_EQ(executor_->run_with({}, item), 1U);
    EXPECT_FALSE(item.left) << "the run came back while the item was held";
    item.go_on = true;
    executor_->settle();
    EXPECT_TRUE(item.left);
    EXPECT_EQ(item.committed, 0);
  }
}

TEST_P(GiveUp, WaitsForAnItemThatHasCommitted) {
  for (int round = 0; round < 8; ++round) {
    HeldItem item{*executor_, true};
    EXPECT_EQ(executor_->run_with({}, item), 0U);
    EXPECT_TRUE(item.left);
    EXPECT_EQ(item.committed, 1);
    executor_->settle();
  }
}

TEST_P(GiveUp, WaitsForItemsWhilePatienceLasts) {
  HeldItem item{*executor_, false};
  std::jthread helper([&] {
    while (!item.held) std::this_thread::yield();
    item.go_on = true;
  });
  EXPECT_EQ(executor_->run_with({{}, std::chrono::seconds(60)}, item), 0U);
  EXPECT_TRUE(item.left);
  EXPECT_EQ(item.committed, 1);
}

TEST_P(GiveUp, RunsOtherLoopsWhileAWorkerIsStillHeldUp) {
  HeldItem item{*executor_, false};
  ASSERT_EQ(executor_->run_with({}, item), 1U);
  std::vector<int> visits(1000, 0);
  for (int run = 0; run < 50; ++run) {
    parallel_for(*executor_, visits.size(), 7, [&](std::size_t begin, std::size_t end, int worker) {
      EXPECT_EQ(worker, 0) << "the other one is held up";
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
  }
  EXPECT_EQ(visits, std::vector<int>(1000, 50));
  EXPECT_FALSE(item.left);
  item.go_on = true;
  executor_->settle();
  EXPECT_EQ(item.committed, 0);
}

// A run that may not abandon does not wait for a worker that was abandoned before it. So such a worker must not begin
// an item in it.
TEST(WorkerGate, AWorkerThatIsAbandonedBeforeItLooksBeginsNothingInTheNextRun) {
  WorkerGate gate(2, std::chrono::nanoseconds(0));
  int items = 0;
  const auto step = [&](int) { return ++items < 3; };
  gate.open(step, true);
  WorkerGateAccess::raise(gate, 1);
  ASSERT_TRUE(WorkerGateAccess::may_begin(gate, 1)) << "while the run is open";
  ASSERT_EQ(gate.close(Patience{}), 1U);
  gate.open(step, false);
  EXPECT_FALSE(WorkerGateAccess::may_begin(gate, 1));
  gate.close();
  gate.open(step, false);
  EXPECT_FALSE(WorkerGateAccess::may_begin(gate, 1));
  WorkerGateAccess::leave(gate, 1);
  // After it has been idle it is like any other worker.
  std::uint64_t last_run = 0;
  EXPECT_TRUE(gate.take_part(1, last_run));
  EXPECT_EQ(items, 3);
  gate.close();
  EXPECT_FALSE(gate.take_part(1, last_run));
}

// A worker that has left its item sets its word once more, to see whether there is another one. Whoever closes the run
// and has seen it empty must not take that for an item.
TEST(WorkerGate, AWorkerThatLooksForMoreWhileItIsWaitedForIsNotAbandoned) {
  for (int round = 0; round < 500; ++round) {
    WorkerGate gate(2, std::chrono::nanoseconds(0));
    const auto step = [](int) { return false; };
    std::atomic<bool> closed{false};
    gate.open(step, true);
    WorkerGateAccess::raise(gate, 1);
    std::jthread worker([&] {
      std::this_thread::sleep_for(std::chrono::microseconds(20));  // the caller waits
      while (!closed) {
        WorkerGateAccess::leave(gate, 1);
        WorkerGateAccess::raise(gate, 1);
      }
      WorkerGateAccess::leave(gate, 1);
    });
    EXPECT_EQ(gate.close({{}, std::chrono::seconds(60)}), 0U);
    closed = true;
  }
}

// Time of this thread alone, whatever else runs.
void work_for_two_milliseconds() {
  const auto cpu_ns = [] {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
  };
  for (const std::int64_t end = cpu_ns() + 2'000'000; cpu_ns() < end;) {
  }
}

TEST(WorkerGate, TellsWhatItSleptForAWorkerFromWhatTheSystemTookOfThatWorker) {
  for (const bool works : {true, false}) {
    WorkerGate gate(2, std::chrono::nanoseconds(0));
    std::atomic<bool> begun{false}, woken{false}, read{false}, closed{false};
    // Or until it has slept: a thread may begin late.
    const auto until_asleep = [&] {
      while (!WorkerGateAccess::caller_sleeps(gate) && !closed) std::this_thread::yield();
    };
    const auto step = [&](int) {
      begun = true;
      until_asleep();
      if (works) {
        work_for_two_milliseconds();
      } else {
        woken.wait(false);
      }
      return false;
    };
    gate.open(step, false);
    const std::jthread worker([&] {
      std::uint64_t last_run = 0;
      gate.take_part(1, last_run);
      read.wait(false);  // a thread that has ended has no clock any more
    });
    while (!begun) std::this_thread::yield();
    const std::jthread helper([&] {
      until_asleep();
      if (!works) work_for_two_milliseconds();
      woken = true;
      woken.notify_all();
    });
    EXPECT_EQ(gate.waits().slept.count(), 0);
    gate.close();
    closed = true;
    const Waits waits = gate.waits();
    read = true;
    read.notify_all();
    // One of the two was at work for 2 ms while the caller slept; clocks may differ a little.
    if (works) {
      EXPECT_GE(waits.slept - waits.held_up, std::chrono::milliseconds(1));
    } else {
      EXPECT_GE(waits.held_up, std::chrono::milliseconds(1));
    }
  }
}

TEST_P(GiveUp, SettlesBeforeAnItemMayBeAbandonedAgain) {
  HeldItem first{*executor_, false};
  ASSERT_EQ(executor_->run_with({}, first), 1U);
  std::jthread helper([&] {
    for (int i = 0; i < 3; ++i) std::this_thread::yield();
    first.go_on = true;
  });
  std::atomic<int> items{0};
  const auto step = [&](int) { return ++items < 10; };
  executor_->run_with({{}, std::chrono::seconds(60)}, step);
  EXPECT_TRUE(first.left) << "its function would have been overwritten";
  EXPECT_GE(items, 10);
}

TEST_P(GiveUp, CommitsEveryItemOfAPlainRun) {
  std::atomic<int> refused{0}, items{0};
  for (int run = 0; run < 200; ++run) {
    executor_->run([&](int worker) {
      const int item = ++items;
      if (!executor_->commit(worker)) ++refused;
      return item % 20 != 0;
    });
  }
  EXPECT_EQ(refused, 0);
  EXPECT_GE(items, 200);
}

TEST(CheckExecutor, RefusesWhatTheSystemDoesNotPermitByNameValueAndRule) {
  const auto refusal = [](ExecutorSettings settings) {
    const Status checked = check_executor(settings);
    const auto made = make_executor(settings);
    EXPECT_EQ(checked.ok(), made.ok());
    return checked ? std::string() : checked.error().message;
  };
  ExecutorSettings settings;
  settings.kind = ExecutorKind::Threads;
  settings.threads = 2;
  EXPECT_EQ(refusal(settings), "");
  settings.processors = {100000};
  EXPECT_NE(refusal(settings).find("processors = 100000, must be processors that this process may use"),
            std::string::npos)
      << refusal(settings);
  settings.processors = {-1};
  EXPECT_NE(refusal(settings).find("processors = -1"), std::string::npos);
  settings.processors = {};
  settings.realtime_priority = 100;
  EXPECT_NE(refusal(settings).find("realtime_priority = 100, must be 0 or in [1, 99]"), std::string::npos)
      << refusal(settings);
  settings.realtime_priority = 0;
  settings.spin = std::chrono::seconds(1);
  EXPECT_NE(refusal(settings).find("spin = 1000000000 ns, must be in [0, 10000000]"), std::string::npos)
      << refusal(settings);
  settings.spin = kDefaultSpin;
  settings.kind = ExecutorKind::Tbb;
  settings.processors = {0};
  EXPECT_NE(refusal(settings).find("processors: must be left out with the executor tbb"), std::string::npos)
      << refusal(settings);
}

TEST(CheckExecutor, SaysWhatARealTimePriorityNeedsWhereItIsNotGranted) {
  ExecutorSettings settings;
  settings.kind = ExecutorKind::Threads;
  settings.threads = 2;
  settings.realtime_priority = 10;
  const Status checked = check_executor(settings);
  if (checked) {
    EXPECT_TRUE(make_executor(settings).ok());
  } else {
    EXPECT_NE(checked.error().message.find("realtime_priority = 10, must be granted by the system"), std::string::npos)
        << checked.error().message;
    EXPECT_NE(checked.error().message.find("ulimit -r"), std::string::npos);
  }
}

// Each holds its first item until the other has one too, so that both took part.
TEST(ThreadsOfOurOwn, RunOnTheProcessorsThatTheyWereGiven) {
  cpu_set_t allowed;
  ASSERT_EQ(sched_getaffinity(0, sizeof(allowed), &allowed), 0);
  int last = -1;
  for (int i = 0; i < CPU_SETSIZE; ++i) {
    if (CPU_ISSET(static_cast<std::size_t>(i), &allowed)) last = i;
  }
  ExecutorSettings settings;
  settings.kind = ExecutorKind::Threads;
  settings.threads = 2;
  settings.processors = {last};
  const auto executor = make_executor(settings);
  ASSERT_TRUE(executor.ok()) << executor.error().message;
  std::atomic<int> present{0};
  int count = 0;
  bool on_it = false;
  executor.value()->run([&](int worker) {
    ++present;
    while (present < 2) std::this_thread::yield();
    if (worker == 0) return;
    cpu_set_t own;
    sched_getaffinity(0, sizeof(own), &own);
    count = CPU_COUNT(&own);
    on_it = CPU_ISSET(static_cast<std::size_t>(last), &own);
  });
  EXPECT_EQ(count, 1);
  EXPECT_TRUE(on_it);
}

}  // namespace
}  // namespace poise::parallel
