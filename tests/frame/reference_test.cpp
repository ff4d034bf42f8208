// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "collision/triangles/true_surface.h"
#include "frame/scenes.h"
#include "geometry/meshes.h"

namespace poise {
namespace {

WorldSettings settings_with(ExecutorKind executor, int threads, double gravity = 9.81) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -gravity);
  settings.executor = executor;
  settings.threads = threads;
  return settings;
}

StepInput referred(double dt_s = 1.0 / 60) {
  StepInput input = step_of(dt_s);
  input.reference = true;
  return input;
}

TEST(Reference, IsNotMadeWhereItIsNotAskedFor) {
  Stage stage(settings_with(ExecutorKind::Serial, 1));
  stage.jacks(4, 5);
  EXPECT_FALSE(stage.world.step(step_of(1.0 / 60)).reference);
  EXPECT_FALSE(stage.world.step(referred(-1)).reference);
  EXPECT_TRUE(stage.world.step(referred()).reference);
}

TEST(Reference, OfTwoBallsThatMeetIsTheRunItself) {
  for (const double e : {0.0, 0.5, 1.0}) {
    Stage stage(settings_with(ExecutorKind::Serial, 1, 0), e);
    const ShapeId ball = stage.ball(0.5);
    stage.add(ball, Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 0, 3));
    stage.add(ball, Vec3(1.005, 0.1, 0), Vec3(-1, 0, 0));
    // The caller's forces belong to the state from which both start.
    ASSERT_TRUE(stage.world.apply_force(stage.bodies[0], Vec3(900, 5, 0), Vec3(0.1, 0.2, 0.3)).ok());
    const FrameReport report = stage.world.step(referred());
    ASSERT_TRUE(report.reference);
    EXPECT_EQ(report.reference->bodies_touched, 2U);
    EXPECT_EQ(report.reference->run_contacts, 1U);
    EXPECT_EQ(report.reference->reference_contacts, 1U);
    EXPECT_EQ(report.reference->e_mps.value(), 0);
    EXPECT_EQ(report.reference->e_rel.value(), 0);
    EXPECT_EQ(report.reference->e_seen_mps.value(), 0);
    EXPECT_GT(report.reference->change_mps.value(), 0.5);
    EXPECT_TRUE(report.reference->converged);
    EXPECT_NEAR(report.reference->gap_max_m.value(), std::hypot(1.005, 0.1) - 1, 1e-12);
    EXPECT_EQ(report.reference->false_contacts + report.reference->missed_contacts, 0U);
  }
}

ShapePtr sphere_l() {
  std::vector<Sphere> leaves;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      if (i > 2 && j > 2) continue;
      for (int k = 0; k < 2; ++k) leaves.push_back({0.1 * Vec3(i, j, k), 0.08});
    }
  }
  return make_spheres_shape(leaves).value();
}

ShapePtr mesh_box() {
  TreeBuildOptions options;
  options.preset = TreePreset::Fast;
  options.depth = 2;
  return make_mesh_shape(test::box_mesh(Vec3(0.8, 0.6, 0.5)), options).value();
}

// Many pairs of bodies of one shape, moving toward each other with a tiny separation of their true surfaces.
class Touches {
 public:
  Touches(ShapePtr shape, int pairs)
      : shape_(std::move(shape)), stage_(settings_with(ExecutorKind::Threads, 2, 0), 0.5) {
    const ShapeId id = stage_.world.add_shape(shape_);
    const collision::TrueSurface surface = collision::true_surface_of(*shape_);
    std::mt19937_64 bits(11);
    const auto unit = [&] { return static_cast<double>(bits() >> 11U) * 0x1.0p-53 - 0.5; };
    for (int i = 0; i < pairs; ++i) {
      const Quat turn_a = Quat(unit(), unit(), unit(), unit()).normalized();
      const Quat turn_b = Quat(unit(), unit(), unit(), unit()).normalized();
      const Vec3 place(5.0 * i, 0, 0);
      const Vec3 way = Vec3(0.2 * unit(), unit(), unit()).normalized();
      double apart = 3;
      for (int k = 0; k < 60; ++k) {
        const double gap = collision::surface_distance_m(surface, {Vec3::Zero(), turn_a.toRotationMatrix()}, surface,
                                                         {apart * way, turn_b.toRotationMatrix()});
        if (gap < 1.5e-3) break;
        apart -= gap - 1e-3;
      }
      const Vec3 offset = shape_->origin_offset_m;
      stage_.add(id, place - turn_a * offset, 1.0 * way, Vec3::Zero(), turn_a);
      stage_.add(id, place + apart * way - turn_b * offset, -1.0 * way, Vec3::Zero(), turn_b);
    }
    for (const BodyId body : stage_.bodies) start_.push_back(stage_.at(body));
  }
  ReferenceFigures at(Level level, const Budget& budget, bool polygons = false) {
    for (std::size_t i = 0; i < start_.size(); ++i)
      EXPECT_TRUE(stage_.world.set_state(stage_.bodies[i], start_[i]).ok());
    StepInput input = referred();
    input.max_level = level;
    input.polygons = polygons;
    input.budget = budget;
    return stage_.world.step(input).reference.value();
  }
  [[nodiscard]] Level depth() const { return shape_->tree.depth(); }

 private:
  ShapePtr shape_;
  Stage stage_;
  std::vector<BodyState> start_;
};

TEST(Reference, FindsAnErrorWithoutABudgetThatFallsWithTheLevel) {
  Touches touches(sphere_l(), 24);
  const ReferenceFigures none = touches.at(kMaxTreeDepth, Budget::work(0));
  EXPECT_GT(none.e_rel.value(), 0.3);
  EXPECT_GT(none.bodies_touched, 40U);
  double before = none.e_mps.value();
  for (Level level = 0; level <= touches.depth(); ++level) {
    const ReferenceFigures here = touches.at(level, Budget::unlimited());
    if (level == 0) {
      EXPECT_EQ(here.e_mps.value(), before) << "no budget is level 0";
    } else {
      EXPECT_LT(here.e_mps.value(), before) << int{level};
    }
    if (level == touches.depth()) {
      EXPECT_LT(here.e_mps.value(), 0.1 * none.e_mps.value());
    }
    EXPECT_TRUE(here.converged);
    EXPECT_EQ(here.change_mps.value(), none.change_mps.value()) << "the reference is the same whatever the run did";
    before = here.e_mps.value();
  }
}

TEST(Reference, OfMeshesIsWhatTheirPolygonsSay) {
  Touches touches(mesh_box(), 16);
  const ReferenceFigures coarse = touches.at(kMaxTreeDepth, Budget::work(0));
  const ReferenceFigures leaves = touches.at(kMaxTreeDepth, Budget::unlimited());
  const ReferenceFigures polygons = touches.at(kMaxTreeDepth, Budget::unlimited(), true);
  EXPECT_GT(coarse.e_rel.value(), 0.3);
  EXPECT_LT(leaves.e_mps.value(), coarse.e_mps.value());
  EXPECT_GT(leaves.e_mps.value(), 0) << "leaves stand out of the mesh";
  EXPECT_NEAR(polygons.e_mps.value(), 0, 1e-12);
  EXPECT_EQ(polygons.run_contacts, 16U);
  EXPECT_EQ(polygons.false_contacts + polygons.missed_contacts, 0U);
  // The separations of these pairs were set by their true surfaces.
  EXPECT_LT(polygons.gap_max_m.value(), 1.5e-3);
  EXPECT_GT(polygons.gap_mean_m.value(), 1e-4);
  EXPECT_EQ(polygons.change_mps.value(), coarse.change_mps.value());
}

TEST(Reference, IsTheSameWhateverTheContactModelOfTheRun) {
  std::optional<double> change[2];
  for (const ContactModel model : {ContactModel::Fitted, ContactModel::Paper}) {
    WorldSettings settings = settings_with(ExecutorKind::Serial, 1);
    settings.contact = model;
    Stage stage(settings, 0.5);
    const ShapeId jack = stage.jack();
    stage.add(jack, Vec3(0, 0, 0), Vec3(0, 3, 0), Vec3(1, 0, 2));
    stage.add(jack, Vec3(0.1, 1.2, 0.3), Vec3(0, -3, 0));
    const ReferenceFigures figures = stage.world.step(referred()).reference.value();
    change[model == ContactModel::Paper ? 1 : 0] = figures.change_mps;
    EXPECT_EQ(figures.reference_contacts, 1U);
    EXPECT_EQ(figures.e_mps.value() == 0, model == ContactModel::Fitted);
  }
  EXPECT_EQ(change[0].value(), change[1].value());
}

TEST(Reference, LeavesARunAsItWasToTheBit) {
  for (const ContactModel model : {ContactModel::Fitted, ContactModel::Wrench, ContactModel::Paper}) {
    std::uint64_t hash[2] = {0, 0};
    std::size_t contacts[2] = {0, 0};
    for (const bool with : {false, true}) {
      WorldSettings settings = settings_with(ExecutorKind::Threads, 2);
      settings.contact = model;
      Stage stage(settings, 0.3);
      stage.jacks(60, 5);
      StepInput input = step_of(1.0 / 60);
      input.budget = Budget::work(60);
      for (int i = 0; i < 150; ++i) {
        input.reference = with && i % 3 == 0;
        // A removed body, and forces for the next step, must also be preserved.
        if (i == 100) {
          EXPECT_TRUE(stage.world.remove_body(stage.bodies[7]).ok());
        }
        if (i % 10 == 5) {
          EXPECT_TRUE(
              stage.world.apply_force(stage.bodies[3], Vec3(50, 20, 900), stage.at(stage.bodies[3]).position_m).ok());
          input.reference = with;
        }
        const FrameReport report = stage.world.step(input);
        contacts[with ? 1 : 0] +=
            report.contact_pairs + stage.world.contacts().size() + stage.world.contact_events().size();
      }
      hash[with ? 1 : 0] = stage.world.state_hash();
    }
    EXPECT_EQ(hash[0], hash[1]);
    EXPECT_EQ(contacts[0], contacts[1]);
    EXPECT_GT(contacts[0], 1000U);
  }
}

TEST(Reference, IsTheSameOnAnyNumberOfThreads) {
  std::vector<ReferenceFigures> seen[3];
  const std::pair<ExecutorKind, int> executors[3] = {
      {ExecutorKind::Serial, 1}, {ExecutorKind::Threads, 3}, {ExecutorKind::Tbb, 2}};
  for (std::size_t k = 0; k < 3; ++k) {
    Stage stage(settings_with(executors[k].first, executors[k].second), 0.3);
    stage.jacks(60, 5);
    StepInput input = step_of(1.0 / 60);
    input.budget = Budget::work(40);
    input.view.present = true;
    input.view.position_m = Vec3(-12, 0, 4);
    for (int i = 0; i < 90; ++i) {
      input.reference = i % 15 == 14;
      const FrameReport report = stage.world.step(input);
      if (report.reference) seen[k].push_back(*report.reference);
    }
  }
  for (std::size_t k = 1; k < 3; ++k) {
    ASSERT_EQ(seen[k].size(), 6U);
    for (std::size_t i = 0; i < seen[0].size(); ++i) {
      EXPECT_EQ(seen[k][i].e_mps, seen[0][i].e_mps);
      EXPECT_EQ(seen[k][i].e_seen_mps, seen[0][i].e_seen_mps);
      EXPECT_EQ(seen[k][i].gap_mean_px, seen[0][i].gap_mean_px);
      EXPECT_EQ(seen[k][i].iterations, seen[0][i].iterations);
      EXPECT_EQ(seen[k][i].missed_contacts, seen[0][i].missed_contacts);
    }
  }
  EXPECT_GT(seen[0].back().e_mps.value(), 0);
}

// At rest the converged reference removes all motion that gravity adds, which two iterations cannot.
TEST(Reference, ConvergesToTheRestOfAStack) {
  Stage stage(settings_with(ExecutorKind::Serial, 1), 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 12; ++i) stage.add(ball, Vec3(0, 0, 0.5 + i));
  const FrameReport report = stage.world.step(referred());
  const ReferenceFigures& figures = report.reference.value();
  EXPECT_TRUE(figures.converged);
  EXPECT_GT(figures.iterations, 100U);
  EXPECT_LT(figures.change_mps.value(), 1e-7);
  EXPECT_LT(figures.e_mps.value(), 1e-6) << "a small scene converges by itself";
  EXPECT_EQ(figures.reference_contacts, 12U);
  EXPECT_EQ(figures.false_contacts, 0U);
}

TEST(Reference, IsHeldAgainstTheDeadlineOfTheFrameByNothing) {
  Stage stage(settings_with(ExecutorKind::Serial, 1), 0.3);
  stage.jacks(40, 5);
  StepInput input = referred();
  input.budget = Budget::until(SteadyClock::time_point::max());
  const FrameReport report = stage.world.step(input);
  EXPECT_EQ(report.lateness.count(), 0);
  EXPECT_GT(report.reference.value().time.count(), 0);
  // The reference is computed after the frame has ended, so the two share no time.
  const SteadyClock::time_point begun = SteadyClock::now();
  const FrameReport again = stage.world.step(input);
  EXPECT_LE(again.times.total + again.reference->time, SteadyClock::now() - begun);
}

TEST(Reference, WeighsBodiesBehindAWallLess) {
  double seen[2] = {0, 0};
  for (const bool plate : {false, true}) {
    Stage stage(settings_with(ExecutorKind::Serial, 1, 0), 0.5);
    const ShapeId jack = stage.jack();
    // Arm against arm: a slow pair in the open, and a fast one with the larger error that the wall may hide.
    stage.add(jack, Vec3(10, -3, 0), Vec3(0, 1, 0));
    stage.add(jack, Vec3(10, -1.3, 0.1), Vec3(0, -1, 0));
    stage.add(jack, Vec3(10, 3, 0), Vec3(0, -4, 0));
    stage.add(jack, Vec3(10, 1.3, 0.1), Vec3(0, 4, 0));
    std::vector<Sphere> row;
    for (int i = 0; i < 9; ++i) row.push_back({Vec3(0, 0.1 * i, 0), 0.4});
    BodyDefinition wall;
    wall.shape = stage.world.add_shape(make_spheres_shape(row).value());
    wall.material = stage.material;
    wall.motion = MotionType::Static;
    wall.position_m = Vec3(5, plate ? 0.7 : 40, 0.1);
    ASSERT_TRUE(stage.world.add_body(wall).ok());
    StepInput input = referred();
    input.max_level = 0;
    input.view.present = true;
    input.view.vertical_fov_rad = 1.5;
    const ReferenceFigures figures = stage.world.step(input).reference.value();
    ASSERT_EQ(figures.bodies_touched, 4U);
    seen[plate ? 1 : 0] = figures.e_seen_mps.value();
  }
  EXPECT_GT(seen[1], 0);
  EXPECT_LT(seen[1], 0.9 * seen[0]);
}

}  // namespace
}  // namespace poise
