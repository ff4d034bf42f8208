// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "frame/scenes.h"
#include "geometry/meshes.h"

/// Runs whose decisions are recorded, and repeated.
namespace poise {

/// A run with a wall-clock budget, so that no two runs are alike, and with all features of a step.
struct Case {
  const char* name = "";
  ContactModel contact = ContactModel::Fitted;
  scheduler::PolicyKind policy = scheduler::PolicyKind::Perceptual;
  bool polygons = false, backtracking = false, sleeping = false;
  int frames = 60;
};

struct Recorded {
  std::vector<FrameDecisions> decisions;
  std::vector<std::uint64_t> hashes;
  std::vector<std::vector<PairOutcome>> outcomes;
  std::size_t completed = 0, left = 0, asleep = 0, swept = 0;
  std::uint32_t by_polygons = 0;
};

inline WorldSettings settings_of(const Case& c, ExecutorKind executor, int threads) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.contact = c.contact;
  settings.policy.kind = c.policy;
  settings.sleeping = c.sleeping;
  settings.executor = executor;
  settings.threads = threads;
  return settings;
}

/// Balls that fall asleep before jacks fall onto them.
inline void fill_for_sleep(Stage& stage) {
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 16; ++i) stage.add(ball, Vec3(1.001 * (i % 4), 1.001 * (i / 4), 0.5));
  const ShapeId jack = stage.jack();
  for (int i = 0; i < 8; ++i) stage.add(jack, Vec3(1.4 * (i % 3), 1.5 * (i / 3), 6), Vec3::Zero(), Vec3(1, 0.2 * i, 0));
}

inline void fill(const Case& c, Stage& stage) {
  if (c.sleeping) return fill_for_sleep(stage);
  stage.jacks(60, 4.0);
  if (c.polygons) {
    const ShapeId box = stage.world.add_shape(
        make_mesh_shape(test::box_mesh(Vec3(0.6, 0.6, 0.6)), {.depth = 1, .preset = TreePreset::Fast}).value());
    for (int i = 0; i < 8; ++i)
      stage.add(box, Vec3(-1 + 0.7 * (i % 4), 0.4 * (i / 4), 0.9 + 0.8 * (i / 4)), Vec3(0, 0, -2), Vec3(1, 2, 0.3 * i));
  }
  if (c.backtracking) {
    const ShapeId ball = stage.ball(0.05);
    for (int i = 0; i < 6; ++i) stage.add(ball, Vec3(-1.8, -1.2 + 0.4 * i, 0.8 + 0.2 * i), Vec3(120, 0, 0));
  }
}

inline StepInput input_of(const Case& c) {
  StepInput input = step_of(1.0 / 60);
  input.polygons = c.polygons;
  input.backtracking = c.backtracking;
  const Vec3 forward = Vec3(-1, 1, -0.5).normalized();
  input.view = {true, Vec3(8, -8, 5), forward, Vec3::UnitZ(), 0.87, 1.78, forward};
  return input;
}

/// The first frame with a different state, or the number of frames.
inline std::size_t frames_alike(const Case& c, const Recorded& recorded, ExecutorKind executor, int threads) {
  Stage stage(settings_of(c, executor, threads), 0.2);
  fill(c, stage);
  StepInput input = input_of(c);
  for (std::size_t i = 0; i < recorded.hashes.size(); ++i) {
    input.replay = &recorded.decisions[i];
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(report.status, StepStatus::Done) << c.name << ", frame " << i;
    if (stage.world.state_hash() != recorded.hashes[i]) return i;
  }
  return recorded.hashes.size();
}

}  // namespace poise
