// SPDX-License-Identifier: MIT
#include "studies/overload_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace poise::app {
namespace {

Scene jacks() { return read_scene(POISE_SOURCE_DIR "/scenes/jacks.json").value(); }

SceneRunOptions one_thread() {
  SceneRunOptions options;
  options.world.executor = ExecutorKind::Serial;
  options.world.threads = 1;
  options.world.max_front_entries = 1U << 18U;
  return options;
}

OverloadSettings by_work(std::uint64_t bodies) {
  OverloadSettings settings;
  settings.wall_clock = false;
  settings.bodies = bodies;
  settings.settle = 150;
  settings.hold = 20;
  settings.shake.speed_mps = 0.5;
  return settings;
}

void ignore(double /*share*/) {}

TEST(OverloadLimit, IsTheUnitDividedByTheDemand) {
  const OverloadUnit unit{6, 900};
  EXPECT_EQ(limit_of(unit, 0.5, true).deadline, std::chrono::milliseconds(12));
  EXPECT_EQ(limit_of(unit, 4, true).deadline, std::chrono::microseconds(1500));
  EXPECT_FALSE(limit_of(unit, 4, true).work_units);
  EXPECT_EQ(limit_of(unit, 4, false).work_units, 225U);
  EXPECT_FALSE(limit_of(unit, 4, false).deadline);
  EXPECT_EQ(limit_of(unit, 1e6, false).work_units, 1U) << "never nothing";
}

TEST(DrivenScene, TakesAwayTheLastBodiesAndPoursTheSameOnesIn) {
  const Scene scene = jacks();
  DrivenScene driven = DrivenScene::create(scene, one_thread(), 30, 10, {}).value();
  EXPECT_EQ(driven.population(), 10U);
  for (int i = 0; i < 120; ++i) ASSERT_TRUE(driven.step({}, false));
  ASSERT_TRUE(driven.set_population(1000));
  EXPECT_EQ(driven.population(), 30U) << "no more than were made";
  double highest_j = 0;
  simulation::RunFrame last;
  for (int i = 0; i < 240; ++i) {
    last = driven.step({}, false).value();
    highest_j = std::max(highest_j, last.report.kinetic_j);
  }
  EXPECT_EQ(last.report.bodies, 30U);
  EXPECT_GT(highest_j, 0) << "they fell";
  EXPECT_LT(last.report.kinetic_j, 0.01 * highest_j) << "and came to rest";
  ASSERT_TRUE(driven.set_population(5));
  EXPECT_EQ(driven.step({}, false).value().report.bodies, 5U);
}

TEST(DrivenScene, ABodyWhosePlaceIsNotFreeComesLater) {
  const Scene scene = parse_scene(R"({"name": "s", "dt_s": 0.01, "gravity_mps2": [0, 0, 0], "materials": {"m": {}},
    "shapes": {"ball": {"sphere": {"radius_m": 0.5}}},
    "bodies": [{"shape": "ball", "material": "m", "position_m": [2, 0, 0]}],
    "generators": [{"grid": {"shapes": ["ball"], "material": "m", "count": [2, 1, 1], "origin_m": [0, 0, 0], "spacing_m": 2}}]})",
                                  "s.json", ".")
                          .value();
  DrivenScene driven = DrivenScene::create(scene, one_thread(), 2, 1, {}).value();
  ASSERT_TRUE(driven.set_population(2));
  EXPECT_EQ(driven.population(), 1U) << "the body of the file is in its place";
}

TEST(DrivenScene, ABodyToWhosePlaceAHeapHasRisenComesFromAbove) {
  // Two layers of places; a ball of the file lies in a place of the lower one.
  const Scene scene = parse_scene(R"({"name": "s", "dt_s": 0.01, "gravity_mps2": [0, 0, -10], "materials": {"m": {}},
    "shapes": {"ball": {"sphere": {"radius_m": 0.5}}, "ground": {"plane": {"normal": [0, 0, 1]}}},
    "bodies": [{"shape": "ground", "material": "m", "static": true},
               {"shape": "ball", "material": "m", "position_m": [2, 0, 0.5]}],
    "generators": [{"grid": {"shapes": ["ball"], "material": "m", "count": [2, 1, 2], "origin_m": [0, 0, 0.5], "spacing_m": 2}}]})",
                                  "s.json", ".")
                          .value();
  DrivenScene driven = DrivenScene::create(scene, one_thread(), 4, 1, {}).value();
  ASSERT_TRUE(driven.set_population(4));
  EXPECT_EQ(driven.population(), 4U);
  const simulation::RunFrame frame = driven.step({}, false).value();
  EXPECT_EQ(frame.report.bodies, 5U);
  EXPECT_LT(frame.report.kinetic_j, 30) << "none is thrown out of another one";
}

TEST(DrivenScene, RefusesASceneWhosePopulationChangesByItself) {
  const Scene scene = parse_scene(R"({"name": "s", "dt_s": 0.01, "gravity_mps2": [0, 0, 0], "materials": {"m": {}},
    "shapes": {"ball": {"sphere": {"radius_m": 0.5}}},
    "generators": [{"stream": {"shapes": ["ball"], "material": "m", "per_second": 1, "total": 3, "from_s": 0,
                               "region_min_m": [0, 0, 0], "region_max_m": [1, 1, 1]}}]})",
                                  "s.json", ".")
                          .value();
  const Result<DrivenScene> driven = DrivenScene::create(scene, one_thread(), 2, 1, {});
  ASSERT_FALSE(driven);
  EXPECT_EQ(driven.error().message, "s.json: has a stream, so its population changes by itself and cannot be driven");
}

TEST(OverloadDrive, HasAReferenceInEachNthFrameUnderTheLimitAlone) {
  const Scene scene = jacks();
  OverloadSettings settings = by_work(12);
  settings.settle = 100;
  settings.steps = simulation::overload_steps(0.5, 1);
  settings.reference_every = 7;
  const Result<OverloadDrive> drive = drive_overload(scene, one_thread(), settings, ignore, nullptr);
  ASSERT_TRUE(drive) << drive.error().message;
  ASSERT_EQ(drive.value().frames.size(), 120U);
  for (std::size_t i = 0; i < 120; ++i) {
    EXPECT_EQ(drive.value().frames[i].report.reference.has_value(), (i + 1) % 7 == 0) << i;
    EXPECT_FALSE(drive.value().unlimited[i].report.reference);
  }
}

TEST(OverloadDrive, OnTheWorkClockIsTheSameOnAnyNumberOfThreadsAndKeepsItsLimit) {
  const Scene scene = jacks();
  OverloadSettings settings = by_work(12);
  settings.population = true;
  settings.steps = simulation::overload_steps(0.5, 2);
  const OverloadDrive one = drive_overload(scene, one_thread(), settings, ignore).value();
  SceneRunOptions two = one_thread();
  two.world.executor = ExecutorKind::Threads;
  two.world.threads = 2;
  const OverloadDrive other = drive_overload(scene, two, settings, ignore).value();
  ASSERT_EQ(one.frames.size(), settings.steps.size() * settings.hold);
  ASSERT_EQ(one.unlimited.size(), one.frames.size());
  EXPECT_EQ(one.unit.work_units, other.unit.work_units);
  const std::uint64_t limit = *limit_of(one.unit, 1, false).work_units;
  for (std::size_t i = 0; i < one.frames.size(); ++i) {
    const FrameReport& report = one.frames[i].report;
    EXPECT_EQ(report.kinetic_j, other.frames[i].report.kinetic_j) << i;
    EXPECT_LE(report.work_refine, limit) << i;
    EXPECT_EQ(one.unlimited[i].report.pairs_left, 0U) << i;
  }
  for (std::size_t k = 0; k < settings.steps.size(); ++k)
    EXPECT_EQ(one.unlimited[(k + 1) * settings.hold - 1].report.bodies,
              static_cast<std::size_t>(std::llround(12 * settings.steps[k].demand)))
        << k;
}

TEST(OverloadDrive, RefusesASceneThatHasNothingToRefineOnTheWorkClock) {
  const Scene scene = parse_scene(R"({"name": "s", "dt_s": 0.01, "gravity_mps2": [0, 0, 0], "materials": {"m": {}},
    "shapes": {"ball": {"sphere": {"radius_m": 0.5}}},
    "generators": [{"grid": {"shapes": ["ball"], "material": "m", "count": [2, 2, 2], "origin_m": [0, 0, 0], "spacing_m": 9}}]})",
                                  "s.json", ".")
                          .value();
  OverloadSettings settings = by_work(4);
  settings.steps = simulation::overload_steps(0.5, 1);
  const Result<OverloadDrive> drive = drive_overload(scene, one_thread(), settings, ignore);
  ASSERT_FALSE(drive);
  EXPECT_EQ(drive.error().message, "s.json: has nothing to refine once it has settled, so its demand for work is 0");
}

// Whatever the demand was: with half of the budget wanted, levels are full within a second.
TEST(OverloadDrive, AfterAnyDemandOnAShakenHeapFullLevelsAreBackWithinSixtyFrames) {
  const Scene scene = jacks();
  std::size_t overloaded = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    OverloadSettings settings = by_work(20);
    settings.shake.speed_mps = 1.5;
    settings.population = seed % 2 == 0;
    for (int k = 0; k < 8; ++k) {
      // Up to four times the population, or down to a two-thousandth of the budget.
      const double octave = static_cast<double>(random() % 7) * (settings.population ? 0.5 : 2);
      settings.steps.push_back({true, 0.5 * std::exp2(octave)});
    }
    for (int k = 0; k < 4; ++k) settings.steps.push_back({false, 0.5});
    const OverloadDrive drive = drive_overload(scene, one_thread(), settings, ignore).value();
    const std::size_t driven = 8 * settings.hold;
    const std::span<const simulation::RunFrame> frames = drive.frames;
    const std::span<const simulation::RunFrame> unlimited = drive.unlimited;
    for (const simulation::RunFrame& frame : frames.first(driven)) {
      const auto& contacts = frame.report.level_histogram;
      if (contacts[0] + contacts[1] > 0) ++overloaded;
    }
    const std::optional<std::uint64_t> back =
        simulation::recovery(frames.subspan(driven), unlimited.subspan(driven)).frames;
    ASSERT_TRUE(back);
    EXPECT_LE(*back, 60U);
    EXPECT_TRUE(simulation::recovery(frames.last(10), unlimited.last(10)).frames) << "and stay";
  }
  EXPECT_GT(overloaded, 50U) << "there was no overload to come back from";
}

}  // namespace
}  // namespace poise::app
