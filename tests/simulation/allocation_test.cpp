// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "geometry/meshes.h"
#include "simulation/scenes.h"

namespace {

std::atomic<std::size_t> allocations{0};

void* counted(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return std::malloc(size == 0 ? 1 : size);
}

}  // namespace

void* operator new(std::size_t size) {
  if (void* memory = counted(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  const auto align = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(align, (size + align - 1) / align * align)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace poise {
namespace {

std::size_t allocations_once_warm(ExecutorKind executor, const Budget& budget, ContactModel model) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = executor;
  settings.threads = 2;
  settings.contact = model;
  Stage stage(settings, 0.2);
  stage.jacks(150, 5);
  std::vector<BodyState> start;
  for (const BodyId body : stage.bodies) start.push_back(stage.at(body));
  StepInput input = step_of(1.0 / 60);
  input.budget = budget;
  const auto fall = [&] {
    for (int i = 0; i < 200; ++i) stage.world.step(input);
  };
  fall();
  // The same fall again, to the bit but for the number of the frame: nothing needs more room than it has.
  for (std::size_t i = 0; i < start.size(); ++i) {
    EXPECT_TRUE(stage.world.set_state(stage.bodies[i], start[i]).ok());
  }
  const std::size_t before = allocations.load();
  fall();
  const std::size_t made = allocations.load() - before;
  return made;
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
  for (int i = 0; i < 60; ++i) by_polygons += stage.world.step(input).level_histogram[kPolygonPlace];
  EXPECT_EQ(allocations.load() - before, 0U);
  EXPECT_GT(by_polygons, 60U);
}

TEST(Allocation, TheCounterCounts) {
  const std::size_t before = allocations.load();
  const auto number = std::make_unique<std::size_t>(1);
  EXPECT_EQ(allocations.load() - before, *number);
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
