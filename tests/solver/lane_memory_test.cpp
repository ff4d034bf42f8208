// SPDX-License-Identifier: MIT
#include "solver/lane_memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <span>

#include "parallel/executor.h"
#include "solver/contacts/contact_lanes.h"
#include "solver/impacts/impact_row.h"

namespace poise::solver {
namespace {

TEST(LaneMemory, KeepsWhatItHoldsWhileItGrowsAndBelongsToOneTypeAtATime) {
  const std::unique_ptr<parallel::Executor> executor = parallel::make_executor(ExecutorKind::Serial, 1);
  LaneMemory memory;
  EXPECT_TRUE(memory.use<MotionChange<float>>(0, *executor).empty());
  const std::span<MotionChange<float>> few = memory.use<MotionChange<float>>(3, *executor);
  ASSERT_EQ(few.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) few[i].q[2] = static_cast<float>(i + 1);
  const std::span<MotionChange<float>> many = memory.use<MotionChange<float>>(1000, *executor);
  ASSERT_EQ(many.size(), 1000U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(many[i].q[2], static_cast<float>(i + 1));
  const std::span<MotionChange<double>> others = memory.use<MotionChange<double>>(1000, *executor);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(others.data()) % alignof(MotionChange<double>), 0U);
  others[999].v[0] = 7;
  EXPECT_EQ(memory.use<MotionChange<double>>(1000, *executor)[999].v[0], 7);
  EXPECT_EQ(static_cast<void*>(memory.use<MotionChange<float>>(5, *executor).data()), others.data())
      << "fewer need no new memory";
}

TEST(LaneMemory, WhatWasReservedStaysWhereItIs) {
  const std::unique_ptr<parallel::Executor> executor = parallel::make_executor(ExecutorKind::Serial, 1);
  LaneMemory memory;
  memory.reserve<MotionChange<double>>(100);
  const void* const first = memory.use<MotionChange<double>>(1, *executor).data();
  EXPECT_EQ(static_cast<void*>(memory.use<MotionChange<double>>(100, *executor).data()), first);
  EXPECT_EQ(static_cast<void*>(memory.use_anew<MotionChange<float>>(200).data()), first);
  EXPECT_EQ(memory.use_anew<MotionChange<double>>(300).size(), 300U);
}

TEST(LaneMemory, HoldsTwoArraysAtOnceEachAlignedAndReserved) {
  const std::unique_ptr<parallel::Executor> executor = parallel::make_executor(ExecutorKind::Serial, 1);
  LaneMemory memory;
  memory.reserve<ContactRow, OverlapPoint>(3, 24);
  const void* const first = memory.use<MotionChange<double>>(1, *executor).data();
  const auto [rows, overlaps] = memory.use_anew<ContactRow, OverlapPoint>(3, 24);
  EXPECT_EQ(static_cast<void*>(rows.data()), first);
  ASSERT_EQ(rows.size(), 3U);
  ASSERT_EQ(overlaps.size(), 24U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(rows.data()) % alignof(ContactRow), 0U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(overlaps.data()) % alignof(OverlapPoint), 0U);
  for (ContactRow& row : rows) row.gap_m = 1;
  for (OverlapPoint& overlap : overlaps) overlap.restitution = 2;
  EXPECT_EQ(rows.back().gap_m, 1);
  EXPECT_EQ(overlaps.back().restitution, 2);
  EXPECT_TRUE((memory.use_anew<ContactRow, OverlapPoint>(0, 0).second.empty()));
}

}  // namespace
}  // namespace poise::solver
