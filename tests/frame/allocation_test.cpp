// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>
#include <vector>

#include "frame/scenes.h"
#include "geometry/meshes.h"

namespace {

std::atomic<std::size_t> allocations{0};

void* counted(std::size_t size) noexcept {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return std::malloc(size == 0 ? 1 : size);
}

void* counted(std::size_t size, std::align_val_t alignment) noexcept {
  allocations.fetch_add(1, std::memory_order_relaxed);
  const auto align = static_cast<std::size_t>(alignment);
  return std::aligned_alloc(align, (size + align - 1) / align * align);
}

void* or_throw(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Every form is replaced. Otherwise a sanitizer's own forms would be paired with our free (std::stable_sort allocates
// its buffer by the nothrow form and frees it by the plain one), and their allocations would not be counted.
void* operator new(std::size_t size) { return or_throw(counted(size)); }
void* operator new[](std::size_t size) { return or_throw(counted(size)); }
void* operator new(std::size_t size, std::align_val_t align) { return or_throw(counted(size, align)); }
void* operator new[](std::size_t size, std::align_val_t align) { return or_throw(counted(size, align)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new(std::size_t size, std::align_val_t align, const std::nothrow_t&) noexcept {
  return counted(size, align);
}
void* operator new[](std::size_t size, std::align_val_t align, const std::nothrow_t&) noexcept {
  return counted(size, align);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept { std::free(memory); }

namespace poise {
namespace {

std::size_t allocations_once_warm(ExecutorKind executor, const Budget& budget, ContactModel model,
                                  Trace* trace = nullptr, bool record = false, const scheduler::Policy& policy = {}) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = executor;
  settings.threads = 2;
  settings.contact = model;
  settings.policy = policy;
  Stage stage(settings, 0.2);
  stage.jacks(80, 5);
  std::vector<BodyState> start;
  for (const BodyId body : stage.bodies) start.push_back(stage.at(body));
  StepInput input = step_of(1.0 / 60);
  input.budget = budget;
  input.trace = trace;
  input.record = record;
  const Vec3 forward = Vec3(-1, 1, -0.5).normalized();
  input.view = {true, Vec3(8, -8, 5), forward, Vec3::UnitZ(), 0.87, 1.78, forward};
  const auto fall = [&] {
    for (int i = 0; i < 100; ++i) stage.world.step(input);
  };
  // Repeats the same fall, equal to the bit except for the frame number: no capacity has to grow. What a policy has
  // learned by then makes the next falls others, until it changes little.
  for (int falls = policy.learning > 0 ? 4 : 1; falls > 0; --falls) {
    fall();
    for (std::size_t i = 0; i < start.size(); ++i) {
      EXPECT_TRUE(stage.world.set_state(stage.bodies[i], start[i]).ok());
    }
  }
  const std::size_t before = allocations.load();
  fall();
  const std::size_t made = allocations.load() - before;
  return made;
}

TEST(Allocation, ATraceAllocatesNothingAndWhatFindsNoRoomIsCounted) {
  const Budget ample = Budget::until(SteadyClock::now() + std::chrono::hours(1));
  Trace roomy(10000);
  EXPECT_EQ(allocations_once_warm(ExecutorKind::Threads, ample, ContactModel::Fitted, &roomy), 0U);
  EXPECT_EQ(roomy.discarded(), 0U);
  EXPECT_GE(roomy.spans().size(), 200U * 9U);
  Trace small(10);
  EXPECT_EQ(allocations_once_warm(ExecutorKind::Serial, ample, ContactModel::Fitted, &small), 0U);
  EXPECT_EQ(small.spans().size(), 10U);
  EXPECT_GE(small.discarded(), 200U * 9U - 10U);
}

TEST(Allocation, AllCuesAndLearningAllocateNothingOnceWarm) {
  scheduler::Policy policy;
  for (const scheduler::PolicyField& weight : scheduler::policy_weights()) policy.*weight.value = 1;
  policy.learning = 1;
  EXPECT_EQ(allocations_once_warm(ExecutorKind::Threads, Budget::work(60), ContactModel::Fitted, nullptr, true, policy),
            0U);
  const Budget ample = Budget::until(SteadyClock::now() + std::chrono::hours(1));
  EXPECT_EQ(allocations_once_warm(ExecutorKind::Serial, ample, ContactModel::Fitted, nullptr, false, policy), 0U);
}

TEST(Allocation, PolygonsAllocateNothing) {
  WorldSettings settings;
  settings.executor = ExecutorKind::Serial;
  Stage stage(settings, 0.2);
  const ShapeId box = stage.world.add_shape(
      make_mesh_shape(test::box_mesh(Vec3(1, 1, 1)), {.depth = 1, .preset = TreePreset::Fast}).value());
  stage.add(box, Vec3::Zero(), Vec3(0.1, 0, 0), Vec3(1, 2, 3));
  stage.add(box, Vec3(1.2, 0.1, 0.2), Vec3(-0.1, 0, 0), Vec3(3, 2, 1));
  stage.plane(Vec3::UnitX(), -0.6);
  StepInput input = step_of(1.0 / 60);
  input.polygons = true;
  for (int i = 0; i < 10; ++i) stage.world.step(input);
  const std::size_t before = allocations.load();
  std::uint32_t by_polygons = 0;
  for (int i = 0; i < 60; ++i) by_polygons += stage.world.step(input).level_histogram[kPolygonBin];
  EXPECT_EQ(allocations.load() - before, 0U);
  EXPECT_GT(by_polygons, 60U);
}

TEST(Allocation, BacktrackingAllocatesNothingOnceWarm) {
  WorldSettings settings;
  settings.executor = ExecutorKind::Threads;
  settings.threads = 2;
  Stage stage(settings, 0.9);
  stage.tray(4);
  const ShapeId box = stage.world.add_shape(
      make_mesh_shape(test::box_mesh(Vec3(0.1, 0.1, 0.1)), {.depth = 1, .preset = TreePreset::Fast}).value());
  const ShapeId ball = stage.ball(0.025);
  for (int i = 0; i < 40; ++i) {
    stage.add(i % 4 == 0 ? box : ball, Vec3(-1.5 + 0.4 * (i % 8), -1.5 + 0.5 * (i / 8), 0.2),
              Vec3(300 - 15 * i, 20 * i, 2 * i));
  }
  std::vector<BodyState> start;
  for (const BodyId body : stage.bodies) start.push_back(stage.at(body));
  StepInput input = step_of(1.0 / 60);
  input.backtracking = true;
  std::size_t hits = 0;
  const auto fly = [&] {
    for (std::size_t i = 0; i < start.size(); ++i) EXPECT_TRUE(stage.world.set_state(stage.bodies[i], start[i]).ok());
    for (int i = 0; i < 15; ++i) hits += stage.world.step(input).swept_hits;
  };
  fly();
  fly();
  const std::size_t before = allocations.load();
  fly();
  EXPECT_EQ(allocations.load() - before, 0U);
  EXPECT_GT(hits, 300U);
}

TEST(Allocation, SleepingAndWakingAllocateNothingOnceWarm) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = ExecutorKind::Threads;
  settings.threads = 2;
  settings.sleeping = true;
  Stage stage(settings, 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 40; ++i) stage.add(ball, Vec3(1.001 * (i % 8), 1.001 * (i / 8), 0.5));
  std::size_t fell_asleep = 0;
  std::size_t woken = 0;
  const auto cycle = [&] {
    EXPECT_TRUE(stage.world.apply_torque(stage.bodies[0], Vec3(0, 0, 1e-6)).ok());
    for (int i = 0; i < 40; ++i) {
      const FrameReport report = stage.world.step(step_of(1.0 / 60));
      fell_asleep += report.fell_asleep;
      woken += report.woken;
    }
  };
  cycle();
  cycle();
  const std::size_t before = allocations.load();
  cycle();
  EXPECT_EQ(allocations.load() - before, 0U);
  EXPECT_EQ(fell_asleep, 120U);
  EXPECT_EQ(woken, 80U);
}

TEST(Allocation, EveryFormOfNewIsCountedOnceAndPairsWithDelete) {
  constexpr std::align_val_t kLine{64};
  const std::size_t before = allocations.load();
  // Called by name, since a new expression may be optimised away.
  ::operator delete(::operator new(24), 24);
  EXPECT_EQ(allocations.load() - before, 1U);
  ::operator delete[](::operator new[](24));
  EXPECT_EQ(allocations.load() - before, 2U);
  ::operator delete(::operator new(24, kLine), kLine);
  EXPECT_EQ(allocations.load() - before, 3U);
  ::operator delete[](::operator new[](24, kLine), kLine);
  EXPECT_EQ(allocations.load() - before, 4U);
  ::operator delete(::operator new(24, std::nothrow));
  EXPECT_EQ(allocations.load() - before, 5U);
  ::operator delete[](::operator new[](24, std::nothrow));
  EXPECT_EQ(allocations.load() - before, 6U);
  ::operator delete(::operator new(24, kLine, std::nothrow), kLine);
  EXPECT_EQ(allocations.load() - before, 7U);
  ::operator delete[](::operator new[](24, kLine, std::nothrow), kLine);
  EXPECT_EQ(allocations.load() - before, 8U);
}

TEST(Allocation, AStableSortIsSeenToTakeItsBuffer) {
  std::vector<int> numbers(1000, 1);
  const std::size_t before = allocations.load();
  std::stable_sort(numbers.begin(), numbers.end());
  EXPECT_EQ(allocations.load() - before, 1U);
}

TEST(Allocation, RecordingWhatAStepDecidesAllocatesNothingOnceWarm) {
  for (const Budget& budget : {Budget::unlimited(), Budget::work(500), Budget::within(std::chrono::hours(1))}) {
    EXPECT_EQ(allocations_once_warm(ExecutorKind::Threads, budget, ContactModel::Fitted, nullptr, true), 0U);
  }
}

TEST(Allocation, AStepAllocatesNothingOnceItsBuffersHaveGrown) {
  for (const ContactModel model : {ContactModel::Wrench, ContactModel::Paper, ContactModel::Fitted}) {
    for (const Budget& budget : {Budget::unlimited(), Budget::work(500), Budget::until(SteadyClock::time_point{})}) {
      EXPECT_EQ(allocations_once_warm(ExecutorKind::Serial, budget, model), 0U);
      EXPECT_EQ(allocations_once_warm(ExecutorKind::Threads, budget, model), 0U);
    }
  }
}

}  // namespace
}  // namespace poise
