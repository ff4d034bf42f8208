// SPDX-License-Identifier: MIT
#include "poise/scheduler/priority_bands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

namespace poise::scheduler {
namespace {

TEST(OctaveBand, BeginsExactlyAtEachQuarterOfAnOctave) {
  const std::vector<double> quarters{1, 1.1892071150027210667, 1.4142135623730950488, 1.6817928305074290861};
  for (std::uint32_t band = 1; band < kBands; ++band) {
    for (const double lowest : {-32.0, -56.0, 3.0, 0.75}) {
      const auto at = static_cast<int>(band) + static_cast<int>(4 * lowest) + 400;
      const double begin = std::ldexp(quarters[static_cast<std::size_t>(at % 4)], at / 4 - 100);
      EXPECT_EQ(octave_band(begin, lowest), band) << lowest;
      EXPECT_EQ(octave_band(std::nextafter(begin, 0), lowest), band - 1) << lowest;
    }
  }
}

TEST(OctaveBand, MayBeginAnywhereAndTakesEveryScore) {
  EXPECT_EQ(octave_band(std::exp2(10.3 + 5.01), 10.3), 20U);
  EXPECT_EQ(octave_band(std::exp2(10.3 + 4.99), 10.3), 19U);
  EXPECT_EQ(octave_band(std::numeric_limits<double>::infinity()), kBands - 1);
  EXPECT_EQ(octave_band(std::numeric_limits<double>::denorm_min()), 0U);
  EXPECT_EQ(octave_band(std::numeric_limits<double>::denorm_min(), -1080), 24U);
  EXPECT_EQ(octave_band(std::numeric_limits<double>::quiet_NaN()), 0U);
}

TEST(PriorityBands, AreEmptyAfterAReset) {
  PriorityBands bands;
  bands.reset(4);
  EXPECT_EQ(bands.take(), PriorityBands::kNone);
  bands.put(2, 7);
  bands.reset(4);
  EXPECT_EQ(bands.take(), PriorityBands::kNone);
}

TEST(PriorityBands, ServeTheHighestBandFirstAndTheLastComerWithinIt) {
  PriorityBands bands;
  bands.reset(6);
  bands.put(0, 0);
  bands.put(1, 64);
  bands.put(2, 255);
  bands.put(3, 63);
  bands.put(4, 255);
  bands.put(5, 128);
  std::vector<std::uint32_t> order;
  for (std::uint32_t item = bands.take(); item != PriorityBands::kNone; item = bands.take()) order.push_back(item);
  EXPECT_EQ(order, (std::vector<std::uint32_t>{4, 2, 5, 1, 3, 0}));
}

TEST(PriorityBands, TellTheHighestBandThatHasAnItem) {
  PriorityBands bands;
  bands.reset(3);
  EXPECT_EQ(bands.highest(), 0U);
  bands.put(0, 5);
  bands.put(1, 200);
  EXPECT_EQ(bands.highest(), 200U);
  bands.take();
  bands.put(2, 70);
  bands.take();
  EXPECT_LE(bands.highest(), 70U) << "a band may be told that has just become empty";
  bands.take();
  bands.take();
  EXPECT_EQ(bands.highest(), 0U);
}

TEST(PriorityBands, TakeBackAnItemInAnotherBand) {
  PriorityBands bands;
  bands.reset(2);
  bands.put(0, 200);
  bands.put(1, 100);
  EXPECT_EQ(bands.take(), 0U);
  bands.put(0, 50);
  EXPECT_EQ(bands.take(), 1U);
  EXPECT_EQ(bands.take(), 0U);
  EXPECT_EQ(bands.take(), PriorityBands::kNone);
}

TEST(PriorityBands, CountABandBeyondTheLastAsTheLast) {
  PriorityBands bands;
  bands.reset(2);
  bands.put(0, kBands - 2);
  bands.put(1, 0xffffffffU);
  EXPECT_EQ(bands.take(), 1U);
  EXPECT_EQ(bands.take(), 0U);
}

// Every item passes through five bands. Its count is a plain number, ordered by the bands alone: an item that two
// workers hold at once, or that is passed on without ordering, is also a race for the thread sanitizer.
TEST(PriorityBands, HandEachItemFromOneWorkerToTheNextAndLoseNone) {
  constexpr std::uint32_t kItems = 3000;
  constexpr std::uint32_t kRounds = 5;
  for (const int threads : {1, 2, 8}) {
    for (int run = 0; run < 10; ++run) {
      PriorityBands bands;
      bands.reset(kItems);
      std::vector<std::uint32_t> served(kItems, 0);
      for (std::uint32_t item = 0; item < kItems; ++item) bands.put(item, item % kBands);
      const auto work = [&] {
        for (std::uint32_t item = bands.take(); item != PriorityBands::kNone; item = bands.take()) {
          if (++served[item] < kRounds) bands.put(item, (item * 31 + served[item] * 17) % kBands);
        }
      };
      {
        std::vector<std::jthread> workers;
        for (int t = 0; t < threads; ++t) workers.emplace_back(work);
      }
      EXPECT_TRUE(std::ranges::all_of(served, [](std::uint32_t count) { return count == kRounds; }))
          << threads << " threads";
      EXPECT_EQ(bands.take(), PriorityBands::kNone);
    }
  }
}

}  // namespace
}  // namespace poise::scheduler
