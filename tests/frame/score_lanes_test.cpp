// SPDX-License-Identifier: MIT
#include "frame/refine/score_lanes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "frame/refine/pair_cues.h"
#include "frame/run_frame.h"
#include "frame/scenes.h"
#include "verify/world_access.h"

namespace poise {
namespace {

using simulation::WorldAccess;
using simulation::WorldState;

// Jacks and balls that fall into a tray and onto each other, and spin.
void fill(Stage& stage) {
  stage.jacks(250, 6);
  std::mt19937_64 random(3);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-52 - 1.0; };
  const ShapeId ball = stage.ball(0.3);
  for (int i = 0; i < 100; ++i) {
    const double x = 2.6 * unit(), y = 2.6 * unit(), z = 4 + 3 * unit(), spin = 5 * unit();
    stage.add(ball, Vec3(x, y, z), Vec3(0, 0, spin), Vec3(spin, 1, -spin));
  }
  for (const BodyId body : stage.bodies) EXPECT_TRUE(stage.world.set_importance(body, 1.5 + unit()));
}

StepInput seen() {
  StepInput input = step_of(1.0 / 60);
  input.view = {
      true, Vec3(5, -6, 4), Vec3(-5, 6, -4).normalized(), Vec3::UnitZ(), 0.25, 1.5, Vec3(-4, 5, -4).normalized()};
  return input;
}

simulation::RefineInput refine_input(const WorldState& world, const scheduler::Policy& policy, const StepInput& input) {
  simulation::RefineInput refine{
      world.scene(), simulation::terms_of(world.settings, input), world.outputs.motion, world.outputs.table, policy,
      input};
  refine.points = &world.cache.points;
  return refine;
}

class ScoreLanes : public ::testing::Test {
 protected:
  ScoreLanes() : stage_(settings()) {
    fill(stage_);
    // A little work in each frame: some pairs are known, others were, and of some nothing is.
    step(50);
  }
  void step(int frames) {
    StepInput input = seen();
    input.budget = Budget::work(1500);
    for (int frame = 0; frame < frames; ++frame) stage_.world.step(input);
  }
  static WorldSettings settings() {
    WorldSettings settings;
    settings.threads = 1;
    settings.gravity_mps2 = Vec3(0, 0, -9.81);
    return settings;
  }
  // Compares all pairs, `at_once` at a time.
  void expect_same(const scheduler::Policy& policy, const StepInput& input, std::size_t at_once) {
    ASSERT_TRUE(simulation::scores_in_lanes(policy));
    const WorldState& world = WorldAccess::of(stage_.world);
    const simulation::RefineInput refine = refine_input(world, policy, input);
    const scheduler::FrameFacts facts = simulation::frame_facts(refine);
    const simulation::PairCueSource source(refine);
    simulation::LaneScorer scorer(refine);
    std::vector<simulation::PairProgress> progress;
    std::vector<std::uint32_t> waiting;
    for (std::uint32_t i = 0; i < refine.table.size(); ++i) {
      progress.emplace_back(refine.table.start[i]);
      if (progress.back().refinable()) waiting.push_back(i);
    }
    for (std::size_t first = 0; first < waiting.size(); first += at_once) {
      const std::span<const std::uint32_t> pairs =
          std::span(waiting).subspan(first, std::min(at_once, waiting.size() - first));
      simulation::LaneScorer::Scored scored;
      scorer.score(pairs, progress, scored);
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        scheduler::PairCues cues;
        source.fill(pairs[k], cues);
        const double score = simulation::score_of(refine, facts, cues, progress[pairs[k]], {}, pairs[k]);
        EXPECT_NEAR(scored.score(k), score, 1e-5 * score) << pairs[k];
        const double seen_radpm = cues.visibility * cues.angle_radpm;
        EXPECT_NEAR(scored.seen_radpm(k), seen_radpm, 1e-12 * seen_radpm) << pairs[k];
        ++compared_;
        const simulation::ActivePair& pair = refine.table.pairs[pairs[k]];
        with_points_ += pair.cached->point_count > 0 ? 1 : 0;
        with_plane_ += refine.motion.body_bounds[pair.b].plane ? 1 : 0;
        unknown_ += pair.cached->reach_m == 0 ? 1 : 0;
        outside_ += cues.visibility < 1 ? 1 : 0;
      }
    }
  }

  Stage stage_;
  int compared_ = 0, with_points_ = 0, with_plane_ = 0, unknown_ = 0, outside_ = 0;
};

TEST_F(ScoreLanes, AreThoseOfPairsOneByOne) {
  // Of several frames: how many pairs are of which kind in one of them is up to their motion.
  for (int i = 0; i < 8; ++i) {
    step(2);
    expect_same({}, seen(), simulation::LaneScorer::kMostPairs);
  }
  EXPECT_GT(compared_, 100);
  EXPECT_GT(with_points_, 10);
  EXPECT_GT(with_plane_, 10);
  EXPECT_GT(unknown_, 10);
  EXPECT_GT(outside_, 10);
  EXPECT_LT(with_points_, compared_);
  expect_same({}, seen(), 3);
  expect_same({}, step_of(1.0 / 60), simulation::LaneScorer::kMostPairs);
}

TEST_F(ScoreLanes, HaveTheWeightsAndParametersOfThePolicy) {
  std::mt19937_64 random(11);
  const auto any_of = [&](std::initializer_list<double> values) { return values.begin()[random() % values.size()]; };
  using scheduler::Policy;
  for (int i = 0; i < 100; ++i) {
    Policy policy;
    for (double Policy::*weight : {&Policy::frustum, &Policy::size, &Policy::eccentricity, &Policy::closing,
                                   &Policy::waiting, &Policy::importance, &Policy::touch})
      policy.*weight = any_of({0, 0.5, 1, 1, 2, 3});
    policy.outside_frustum = any_of({0.05, 0.3});
    policy.eccentricity_e2_rad = any_of({0.04, 0.2});
    policy.closing_scale_mps = any_of({0.1, 1});
    policy.front_growth = any_of({1.5, 2});
    policy.job_overhead_units = any_of({1, 4});
    policy.chance_of_ending = any_of({0.25, 0.5});
    policy.plain_angle_radpm = any_of({0.02, 0.1});
    StepInput input = seen();
    input.view.gaze = i % 2 == 0 ? input.view.gaze : Vec3(0.8, 0.6, 0);
    expect_same(policy, input, simulation::LaneScorer::kMostPairs);
  }
  EXPECT_GT(compared_, 4000);
}

TEST(ScoresInLanes, NotWhereAPolicyAsksForMore) {
  using scheduler::Policy;
  EXPECT_TRUE(simulation::scores_in_lanes({}));
  for (double Policy::*field :
       {&Policy::occlusion, &Policy::gap, &Policy::delay, &Policy::onset, &Policy::crowding, &Policy::attention,
        &Policy::hysteresis, &Policy::learning, &Policy::time_price_rad, &Policy::seen_threshold_rad}) {
    Policy policy;
    policy.*field = 0.5;
    EXPECT_FALSE(simulation::scores_in_lanes(policy));
  }
  Policy hosts;
  hosts.cue.function = [](const scheduler::PairView&, void*) noexcept { return 1.0; };
  EXPECT_FALSE(simulation::scores_in_lanes(hosts));
  Policy rival;
  rival.kind = scheduler::PolicyKind::Fifo;
  EXPECT_FALSE(simulation::scores_in_lanes(rival));
}

// Whoever adds a cue is to say whether it is found in lanes.
TEST(ScoresInLanes, KnowsAllCues) {
  for (const scheduler::PolicyField& weight : scheduler::policy_weights()) {
    scheduler::Policy policy;
    policy.*weight.value = weight.name == "host" ? 1 : 2;
    constexpr std::string_view kInLanes[] = {"frustum", "size",       "eccentricity", "closing",
                                             "waiting", "importance", "touch",        "host"};
    EXPECT_EQ(simulation::scores_in_lanes(policy), std::ranges::find(kInLanes, weight.name) != std::end(kInLanes))
        << weight.name;
  }
}

}  // namespace
}  // namespace poise
