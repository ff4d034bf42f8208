// SPDX-License-Identifier: MIT
#include "parallel/background_queue.h"

#include <gtest/gtest.h>

#include <future>
#include <vector>

namespace poise::parallel {
namespace {

TEST(BackgroundQueue, HandsAllValuesToTheFunctionInOrder) {
  std::vector<int> got;
  BackgroundQueue<int> queue(3, [&](int& value) {
    got.push_back(value);
    return Done{};
  });
  std::vector<int> sent;
  for (int i = 0; i < 1000; ++i) {
    sent.push_back(i);
    queue.push(i);
  }
  queue.close();
  EXPECT_EQ(got, sent);
}

TEST(BackgroundQueue, HasNoRoomOnceItsCapacityWaits) {
  std::promise<void> begun, go;
  std::size_t done = 0;
  BackgroundQueue<int> queue(2, [&](int& value) {
    if (value == 0) {
      begun.set_value();
      go.get_future().wait();
    }
    ++done;
    return Done{};
  });
  EXPECT_TRUE(queue.has_room());
  queue.push(0);
  begun.get_future().wait();
  queue.push(1);
  EXPECT_TRUE(queue.has_room());
  queue.push(2);
  EXPECT_FALSE(queue.has_room());
  go.set_value();
  queue.close();
  EXPECT_EQ(done, 3U);
}

TEST(BackgroundQueue, GivesMemoryBackToBeUsedAgain) {
  BackgroundQueue<std::vector<int>> queue(2, [](std::vector<int>& value) {
    value.clear();
    return Done{};
  });
  queue.push(std::vector<int>(1000, 7));
  queue.close();
  const std::vector<int> again = queue.fresh();
  EXPECT_TRUE(again.empty());
  EXPECT_GE(again.capacity(), 1000U);
  EXPECT_EQ(queue.fresh().capacity(), 0U);
}

TEST(BackgroundQueue, IgnoresWhatComesAfterItsEnd) {
  int sum = 0;
  BackgroundQueue<int> queue(1, [&](int& value) {
    sum += value;
    return Done{};
  });
  queue.push(1);
  queue.close();
  queue.push(2);
  queue.close();
  EXPECT_EQ(sum, 1);
}

TEST(BackgroundQueue, TellsWhatTheFunctionRefusedAndGivesItNothingAfterThat) {
  int calls = 0;
  BackgroundQueue<int> queue(1, [&](int& value) -> Status {
    ++calls;
    if (value < 2) return Done{};
    return Error{ErrorKind::OutputFailed, "full"};
  });
  EXPECT_TRUE(queue.failure());
  for (int i = 0; i < 10; ++i) queue.push(i);
  queue.close();
  ASSERT_FALSE(queue.failure());
  EXPECT_EQ(queue.failure().error().message, "full");
  EXPECT_EQ(calls, 3);
}

}  // namespace
}  // namespace poise::parallel
