// SPDX-License-Identifier: MIT
#include "parallel/shared_counters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <vector>

#include "parallel/executor.h"

namespace poise::parallel {
namespace {

TEST(Tickets, GiveEachNumberToOneWorkerOnly) {
  const auto executor = make_executor(ExecutorKind::Threads, 4);
  std::vector<std::vector<std::size_t>> taken(4);
  Tickets tickets;
  executor->run([&](int worker) {
    for (std::size_t ticket = tickets.take(3); ticket < 9000; ticket = tickets.take(3)) {
      taken[static_cast<std::size_t>(worker)].push_back(ticket);
    }
  });
  std::vector<std::size_t> all;
  for (const auto& part : taken) all.insert(all.end(), part.begin(), part.end());
  std::ranges::sort(all);
  ASSERT_EQ(all.size(), 3000U);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], 3 * i);
}

TEST(Tickets, StartAgainAtZeroAfterAReset) {
  Tickets tickets;
  EXPECT_EQ(tickets.take(5), 0U);
  EXPECT_EQ(tickets.take(), 5U);
  tickets.reset();
  EXPECT_EQ(tickets.take(), 0U);
}

TEST(Shared, LosesNoAddition) {
  const auto executor = make_executor(ExecutorKind::Threads, 2);
  Shared<int> present;
  Shared<long> sum;
  executor->run([&](int) {
    present.add(1);
    while (present.get() < 2) std::this_thread::yield();
    for (int i = 0; i < 200000; ++i) sum.add(1);
  });
  EXPECT_EQ(sum.get(), 400000);
}

TEST(Shared, ShowsWhatWasWrittenBeforeTheValueThatIsSeen) {
  const auto executor = make_executor(ExecutorKind::Threads, 2);
  for (int run = 0; run < 200; ++run) {
    int written = 0;  // plain int: the thread sanitizer reports a race if set() and get() do not order it
    Shared<bool> ready{false};
    Shared<int> seen{0};
    executor->run([&](int worker) {
      if (worker == 0) {
        written = 7;
        ready.set(true);
      } else if (ready.get()) {
        seen.set(written);
      }
    });
    EXPECT_TRUE(seen.get() == 0 || seen.get() == 7) << seen.get();
  }
}

TEST(Shares, AWorkerGetsItsOwnFirstAndThenWhatIsLeftAndEachNumberIsGivenOnce) {
  Shares shares(10, 2);
  EXPECT_EQ(shares.take(1), 5U) << "the second half is the second worker's";
  std::vector<std::size_t> first;
  for (std::size_t n = shares.take(0); n != Shares::kNone; n = shares.take(0)) first.push_back(n);
  EXPECT_EQ(first, (std::vector<std::size_t>{0, 1, 2, 3, 4, 6, 7, 8, 9}));
  EXPECT_EQ(shares.take(1), Shares::kNone);
}

TEST(Shares, FewerNumbersThanWorkersAndMoreWorkersThanShares) {
  for (const int workers : {1, 3, 16, 40}) {
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{33}}) {
      Shares shares(count, workers);
      std::vector<int> given(count, 0);
      for (int w = workers - 1;; w = (w + 1) % workers) {
        const std::size_t n = shares.take(w);
        if (n == Shares::kNone) break;
        ASSERT_LT(n, count);
        ++given[n];
      }
      EXPECT_EQ(given, std::vector<int>(count, 1)) << workers << " workers";
    }
  }
}

}  // namespace
}  // namespace poise::parallel
