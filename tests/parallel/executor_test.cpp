// SPDX-License-Identifier: MIT
#include "parallel/executor.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <array>
#include <atomic>
#include <numeric>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

namespace poise::parallel {
namespace {

struct Choice {
  ExecutorKind kind;
  int threads;
};

void PrintTo(const Choice& choice, std::ostream* out) { *out << choice.threads << " threads"; }

std::string name_of(const testing::TestParamInfo<Choice>& info) {
  const std::array<const char*, 3> kinds{"Tbb", "Threads", "Serial"};
  return kinds.at(static_cast<std::size_t>(info.param.kind)) + std::to_string(info.param.threads);
}

class EveryExecutor : public testing::TestWithParam<Choice> {
 protected:
  std::unique_ptr<Executor> executor_ = make_executor(GetParam().kind, GetParam().threads);
};

INSTANTIATE_TEST_SUITE_P(KindsAndThreads, EveryExecutor,
                         testing::Values(Choice{ExecutorKind::Tbb, 1}, Choice{ExecutorKind::Tbb, 2},
                                         Choice{ExecutorKind::Tbb, 3}, Choice{ExecutorKind::Tbb, 8},
                                         Choice{ExecutorKind::Threads, 1}, Choice{ExecutorKind::Threads, 2},
                                         Choice{ExecutorKind::Threads, 3}, Choice{ExecutorKind::Threads, 8},
                                         Choice{ExecutorKind::Serial, 1}, Choice{ExecutorKind::Serial, 8}),
                         name_of);

TEST_P(EveryExecutor, HasTheConcurrencyThatWasAskedFor) {
  const int expected = GetParam().kind == ExecutorKind::Serial ? 1 : GetParam().threads;
  EXPECT_EQ(executor_->concurrency(), expected);
}

TEST_P(EveryExecutor, VisitsEveryItemExactlyOnce) {
  for (const std::size_t grain : {std::size_t{1}, std::size_t{7}, std::size_t{64}, std::size_t{5000}}) {
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{63}, std::size_t{64}, std::size_t{4099}}) {
      std::vector<int> visits(n, 0);  // plain ints: a second visit would also be a race for the thread sanitizer
      parallel_for(*executor_, n, grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
      EXPECT_EQ(visits, std::vector<int>(n, 1)) << "n " << n << ", grain " << grain;
    }
  }
}

TEST_P(EveryExecutor, TakesAGrainOfZeroForOne) {
  std::atomic<int> chunks{0};
  parallel_for(*executor_, 5, 0, [&](std::size_t begin, std::size_t end, int) {
    EXPECT_EQ(end, begin + 1);
    ++chunks;
  });
  EXPECT_EQ(chunks, 5);
}

TEST_P(EveryExecutor, CutsChunksAtMultiplesOfTheGrainWhateverTheThreads) {
  std::vector<std::size_t> ends(10, 0);
  parallel_for(*executor_, 95, 10, [&](std::size_t begin, std::size_t end, int) { ends[begin / 10] = end; });
  EXPECT_EQ(ends, (std::vector<std::size_t>{10, 20, 30, 40, 50, 60, 70, 80, 90, 95}));
}

TEST_P(EveryExecutor, GivesEachWorkerOfARunItsOwnNumberInRange) {
  const auto workers = static_cast<std::size_t>(executor_->concurrency());
  for (int run = 0; run < 300; ++run) {
    std::vector<std::atomic<int>> calls(workers + 1);
    std::atomic<int> tickets{64};
    executor_->run([&](int worker) {
      ++calls[static_cast<std::size_t>(worker < 0 || worker >= static_cast<int>(workers) ? static_cast<int>(workers)
                                                                                         : worker)];
      while (tickets.fetch_sub(1) > 0) std::this_thread::yield();
    });
    EXPECT_EQ(calls[0], 1) << "the calling thread takes part once";
    for (std::size_t i = 1; i < workers; ++i) EXPECT_LE(calls[i], 1) << "worker " << i;
    EXPECT_EQ(calls[workers], 0) << "numbers out of range";
  }
}

TEST_P(EveryExecutor, CountsTheCallingThreadAsWorkerZero) {
  const std::thread::id caller = std::this_thread::get_id();
  for (int run = 0; run < 300; ++run) {
    std::thread::id zero;
    std::atomic<int> elsewhere{0};
    executor_->run([&](int worker) {
      if (worker == 0) {
        zero = std::this_thread::get_id();
      } else if (std::this_thread::get_id() == caller) {
        ++elsewhere;
      }
    });
    EXPECT_EQ(zero, caller);
    EXPECT_EQ(elsewhere, 0) << "the calling thread came again under another number";
  }
}

// Worker 0 ends the loop at once and the others have nothing to do. A run that waited for all workers would need each
// of 8 threads to be scheduled in each of these runs.
TEST_P(EveryExecutor, FinishesManyEmptyRunsBackToBack) {
  std::atomic<int> zero_calls{0};
  for (int run = 0; run < 5000; ++run) {
    executor_->run([&](int worker) {
      if (worker == 0) ++zero_calls;
    });
  }
  EXPECT_EQ(zero_calls, 5000);
}

TEST_P(EveryExecutor, IsOutOfTheLoopWhenARunReturns) {
  for (int run = 0; run < 2000; ++run) {
    std::vector<int> scratch(8, 0);  // freed right after the run: a late worker would be a use after free
    std::atomic<int> inside{0};
    executor_->run([&](int worker) {
      ++inside;
      ++scratch[static_cast<std::size_t>(worker)];
      --inside;
    });
    ASSERT_EQ(inside, 0);
  }
}

TEST_P(EveryExecutor, MakesWhatWorkersWroteVisibleToTheCaller) {
  std::vector<std::size_t> squares(1000);
  for (int run = 0; run < 200; ++run) {
    parallel_for(*executor_, squares.size(), 16, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) squares[i] = i * i + static_cast<std::size_t>(run);
    });
    const std::size_t sum = std::accumulate(squares.begin(), squares.end(), std::size_t{0});
    ASSERT_EQ(sum, 332833500U + 1000U * static_cast<std::size_t>(run));
  }
}

TEST_P(EveryExecutor, WorksOffARunFromInsideItsOwnLoopOnTheSameThread) {
  for (int run = 0; run < 20; ++run) {
    std::atomic<int> inner{0};
    executor_->run([&](int worker) {
      if (worker != 0) return;
      const std::thread::id outer_thread = std::this_thread::get_id();
      executor_->run([&](int nested_worker) {
        EXPECT_EQ(nested_worker, 0);
        EXPECT_EQ(std::this_thread::get_id(), outer_thread);
        for (int i = 0; i < 50; ++i) std::this_thread::yield();  // time for others to join, if they were called
        ++inner;
      });
    });
    EXPECT_EQ(inner, 1);
  }
}

TEST_P(EveryExecutor, MayRunTheLoopOfAnotherExecutorInsideItsOwn) {
  const auto other = make_executor(GetParam().kind, 2);
  std::atomic<int> items{0};
  executor_->run([&](int worker) {
    if (worker == 0) parallel_for(*other, 100, 1, [&](std::size_t, std::size_t, int) { ++items; });
  });
  EXPECT_EQ(items, 100);
}

TEST_P(EveryExecutor, TakesAWakeAtAnyTime) {
  std::atomic<int> items{0};
  for (int run = 0; run < 200; ++run) {
    executor_->wake();
    parallel_for(*executor_, 8, 1, [&](std::size_t, std::size_t, int) { ++items; });
    executor_->wake();
    executor_->wake();
  }
  EXPECT_EQ(items, 1600);
}

TEST_P(EveryExecutor, EndsWhateverItsWorkersAreDoing) {
  for (int round = 0; round < 50; ++round) {
    const auto untouched = make_executor(GetParam().kind, GetParam().threads);
    const auto used = make_executor(GetParam().kind, GetParam().threads);
    const auto woken = make_executor(GetParam().kind, GetParam().threads);
    std::atomic<int> items{0};
    parallel_for(*used, 16, 1, [&](std::size_t, std::size_t, int) { ++items; });
    woken->wake();
    EXPECT_EQ(items, 16);
  }
}

TEST_P(EveryExecutor, SharesTheMachineWithOthersAtOnce) {
  std::array<std::size_t, 3> sums{};
  {
    std::vector<std::jthread> hosts;
    for (std::size_t& sum : sums) {
      hosts.emplace_back([&sum, choice = GetParam()] {
        const auto executor = make_executor(choice.kind, choice.threads);
        for (int run = 0; run < 100; ++run) {
          std::atomic<std::size_t> total{0};
          parallel_for(*executor, 100, 3, [&](std::size_t begin, std::size_t end, int) { total += end - begin; });
          sum += total;
        }
      });
    }
  }
  EXPECT_EQ(sums, (std::array<std::size_t, 3>{10000, 10000, 10000}));
}

// Each worker holds its first ticket until the other has one too, so the run can only end if two threads took part.
TEST(Executor, BringsASecondThreadToALoopThatNeedsTwo) {
  for (const ExecutorKind kind : {ExecutorKind::Tbb, ExecutorKind::Threads}) {
    const auto executor = make_executor(kind, 2);
    for (int run = 0; run < 20; ++run) {
      std::atomic<int> present{0};
      executor->run([&](int) {
        ++present;
        while (present < 2) std::this_thread::yield();
      });
      EXPECT_EQ(present, 2);
    }
  }
}

TEST(Executor, HasAsManyWorkersAsTheProcessMayUseWhenNoneAreAskedFor) {
  EXPECT_EQ(make_executor(ExecutorKind::Threads, 0)->concurrency(), available_threads());
  EXPECT_EQ(make_executor(ExecutorKind::Tbb, 0)->concurrency(), available_threads());
  EXPECT_EQ(make_executor(ExecutorKind::Threads, -5)->concurrency(), available_threads());
}

TEST(Executor, HasAtMost256Workers) {
  const auto executor = make_executor(ExecutorKind::Threads, 100000);
  EXPECT_LE(executor->concurrency(), 256);
  EXPECT_GE(executor->concurrency(), 1);
  std::atomic<int> items{0};
  parallel_for(*executor, 1000, 1, [&](std::size_t, std::size_t, int) { ++items; });
  EXPECT_EQ(items, 1000);
}

std::vector<bool> processors_of_this_thread() {
  cpu_set_t allowed;
  EXPECT_EQ(sched_getaffinity(0, sizeof(allowed), &allowed), 0);
  std::vector<bool> processors;
  for (std::size_t i = 0; i < CPU_SETSIZE; ++i) processors.push_back(CPU_ISSET(i, &allowed) != 0);
  return processors;
}

TEST(Executor, LeavesTheCallersProcessorsAlone) {
  const std::vector<bool> before = processors_of_this_thread();
  for (const ExecutorKind kind : {ExecutorKind::Tbb, ExecutorKind::Threads}) {
    const auto executor = make_executor(kind, 3);
    for (int run = 0; run < 500; ++run) executor->run([](int) {});
    EXPECT_EQ(processors_of_this_thread(), before);
  }
}

// A thread that may use only one processor: its workers cannot run elsewhere, and the work is done nevertheless.
TEST(Executor, WorksWhereThereIsOneProcessorOnly) {
  std::size_t items = 0;
  std::jthread([&items] {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(sched_getcpu()), &one);
    ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
    EXPECT_EQ(available_threads(), 1);
    const auto executor = make_executor(ExecutorKind::Threads, 3);
    std::atomic<std::size_t> done{0};
    for (int run = 0; run < 50; ++run) parallel_for(*executor, 40, 1, [&](std::size_t, std::size_t, int) { ++done; });
    items = done;
  }).join();
  EXPECT_EQ(items, 2000U);
}

TEST(AvailableThreads, IsAtLeastOneAndAtMostWhatTheMachineHas) {
  EXPECT_GE(available_threads(), 1);
  EXPECT_LE(available_threads(), 100000);
}

}  // namespace
}  // namespace poise::parallel
