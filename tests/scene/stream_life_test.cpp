// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scene/check/scene_check.h"
#include "scene/run/numbered_states.h"
#include "scene/scene_text.h"

namespace poise::testing {
namespace {

// A step of 1/64 s, so that the times of frames are exact.
Scene scene_of(const std::string& streams) {
  const Result<Scene> scene = parse(
      R"({"name": "x", "dt_s": 0.015625, "materials": {"m": {}}, "shapes": {"ball": {"sphere": {"radius_m": 0.5}}},
                "bodies": [{"shape": "ball", "material": "m"}], "generators": [)" +
      streams + "]}");
  EXPECT_TRUE(scene) << scene.error().message;
  return scene.value();
}

/// Far from all others; 16 bodies a second.
std::string stream(const std::string& members, int place = 1) {
  const std::string x = std::to_string(10 * place);
  return R"({"stream": {"shape": "ball", "material": "m", "per_second": 16, "region_min_m": [)" + x +
         R"(, 0, 0], "region_max_m": [)" + x + ", 90, 90], " + members + "}}";
}

std::vector<std::uint64_t> numbers_of(const SceneRun& run) {
  std::vector<std::uint64_t> numbers;
  for (const RunBody& body : run.bodies()) {
    EXPECT_TRUE(run.world().contains(body.id));
    numbers.push_back(body.number);
  }
  EXPECT_EQ(run.world().body_count(), numbers.size());
  return numbers;
}

using Numbers = std::vector<std::uint64_t>;

TEST(StreamLife, EndsBeforeTheFirstFrameAtOrAfterArrivalAndLife) {
  // Due before frames 0, 4 and 8; a life of 5 frames.
  SceneRun run = run_of(scene_of(stream(R"("total": 3, "life_s": 0.078125)")));
  const Numbers expected[] = {{0, 1},    {0, 1}, {0, 1}, {0, 1}, {0, 1, 2}, {0, 2}, {0, 2}, {0, 2},
                              {0, 2, 3}, {0, 3}, {0, 3}, {0, 3}, {0, 3},    {0},    {0}};
  for (std::uint64_t frame = 0; frame < std::size(expected); ++frame) {
    ASSERT_TRUE(run.before_frame(frame));
    EXPECT_EQ(numbers_of(run), expected[frame]) << frame;
    EXPECT_EQ(run.final_body_count(), 1U);
    StepInput input;
    input.dt_s = 0.015625;
    run.world().step(input);
  }
}

TEST(StreamLife, GoesOnWithoutABodyThatTheCallerRemoved) {
  SceneRun run = run_of(scene_of(stream(R"("total": 3, "life_s": 0.078125)")));
  StepInput input;
  input.dt_s = 0.015625;
  for (std::uint64_t frame = 0; frame < 15; ++frame) {
    ASSERT_TRUE(run.before_frame(frame)) << frame;
    if (frame == 2) {
      ASSERT_TRUE(run.world().remove_body(run.bodies().back().id));
    }
    run.world().step(input);
  }
  EXPECT_EQ(numbers_of(run), Numbers{0});
}

TEST(StreamLife, BetweenFramesEndsBeforeTheNextOne) {
  SceneRun run = run_of(scene_of(stream(R"("total": 1, "life_s": 0.08)")));
  for (std::uint64_t frame = 0; frame < 8; ++frame) {
    ASSERT_TRUE(run.before_frame(frame));
    EXPECT_EQ(run.bodies().size(), frame < 6 ? 2U : 1U) << frame;
  }
}

TEST(StreamLife, ShorterThanAFrameIsThatOfOneFrame) {
  SceneRun run = run_of(scene_of(stream(R"("total": 2, "life_s": 1e-6)")));
  for (std::uint64_t frame = 0; frame < 8; ++frame) {
    ASSERT_TRUE(run.before_frame(frame));
    EXPECT_EQ(run.bodies().size(), frame % 4 == 0 ? 2U : 1U) << frame;
  }
}

TEST(StreamLife, IsThatOfEachStreamAndTheOthersStay) {
  SceneRun run = run_of(scene_of(stream(R"("total": 2, "life_s": 0.5)") + ", " + stream(R"("total": 2)", 2) + ", " +
                                 stream(R"("total": 2, "life_s": 0.125)", 3)));
  EXPECT_EQ(run.final_body_count(), 3U);
  const auto at = [&run](std::uint64_t frame) {
    EXPECT_TRUE(run.before_frame(frame));
    return numbers_of(run);
  };
  EXPECT_EQ(at(0), (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(at(4), (Numbers{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(at(8), (Numbers{0, 1, 2, 4, 5, 6}));
  EXPECT_EQ(at(12), (Numbers{0, 1, 2, 4, 5}));
  EXPECT_EQ(at(31), (Numbers{0, 1, 2, 4, 5}));
  EXPECT_EQ(at(32), (Numbers{0, 2, 4, 5}));
  EXPECT_EQ(at(36), (Numbers{0, 2, 5}));
}

TEST(StreamLife, LeavesTheNumbersOfTheStatesAsTheyWere) {
  SceneRun run = run_of(scene_of(stream(R"("total": 3, "life_s": 0.078125)")));
  for (std::uint64_t frame = 0; frame < 9; ++frame) ASSERT_TRUE(run.before_frame(frame));
  std::vector<io::NumberedState> states;
  ASSERT_TRUE(io::read_states(run, states));
  ASSERT_EQ(states.size(), 3U);
  EXPECT_EQ(states[1].body, 2U);
  EXPECT_EQ(states[2].body, 3U);
  EXPECT_EQ(states[2].state.position_m, run.world().state(run.bodies()[2].id).value().position_m);
  ASSERT_TRUE(run.world().remove_body(run.bodies()[1].id));
  EXPECT_EQ(io::read_states(run, states).error().kind, ErrorKind::StaleHandle);
}

TEST(StreamLife, CountsAtMostTheBodiesThatAreThereAtOnce) {
  const auto most = [](const std::string& members) {
    const io::SceneCheck check = io::check_scene(scene_of(stream(members)), {});
    EXPECT_EQ(check.dynamic_bodies, check.bodies);
    return check.bodies;
  };
  EXPECT_EQ(most(R"("total": 160)"), 161U);
  EXPECT_EQ(most(R"("total": 160, "life_s": 100)"), 161U);
  EXPECT_EQ(most(R"("total": 160, "life_s": 1)"), 17U);
}

TEST(StreamLife, GivesTheSameStateTwice) {
  const Scene scene = scene_of(stream(R"("total": 40, "life_s": 0.3, "velocity_mps": [-9, 0, 0])"));
  std::uint64_t hashes[2];
  for (std::uint64_t& hash : hashes) {
    SceneRun run = run_of(scene);
    for (std::uint64_t frame = 0; frame < 100; ++frame) {
      ASSERT_TRUE(run.before_frame(frame));
      StepInput input;
      input.dt_s = 0.015625;
      run.world().step(input);
    }
    EXPECT_LT(run.bodies().size(), 41U);
    hash = run.world().state_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace poise::testing
