// SPDX-License-Identifier: MIT
#include "parallel/shared.h"

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
    int written = 0;  // plain: the thread sanitizer objects if set() and get() do not order it
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

}  // namespace
}  // namespace poise::parallel
