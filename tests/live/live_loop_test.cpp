// SPDX-License-Identifier: MIT
#include "app/live/live_loop.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace poise::app {
namespace {

const char* const kScene = R"({"name": "s", "dt_s": 0.01, "gravity_mps2": [0, 0, -9.81], "materials": {"wood": {}},
  "shapes": {"ball": {"sphere": {"radius_m": 0.5}}},
  "camera": {"position_m": [9, 0, 1], "look_at_m": [0, 0, 1], "up": [0, 0, 1]},
  "tray": {"material": "wood", "side_m": 20},
  "generators": [{"grid": {"shape": "ball", "material": "wood", "count": [3, 3, 1], "spacing_m": 2,
                           "origin_m": [-2, -2, 1]}}]})";

struct Started {
  explicit Started(const std::string& text = kScene)
      : scene(parse_scene(text, "s.json", {}).value()),
        run(scene, start(), SceneRun::create(scene, start()).value(), kDeadline) {}
  static SceneRunOptions start() {
    SceneRunOptions options;
    options.world.executor = ExecutorKind::Serial;
    return options;
  }
  static constexpr Nanoseconds kDeadline{1'000'000'000};

  void ask(const LiveMessage& message, ClientId client = 1) {
    LiveRequest request{client, message};
    EXPECT_TRUE(link.requests.give(request));
  }
  /// Steps without waiting for the time of frames; `before` each look whether to stop, told how many there were.
  std::uint64_t go(
      std::uint64_t frames, std::function<bool(int)> stops = [](int) { return false; }) {
    LiveLoopSettings settings;
    settings.frames = frames;
    settings.paced = false;
    int looks = 0;
    settings.stops = [&looks, stops = std::move(stops)] { return stops(looks++); };
    const Result<std::uint64_t> done = live_loop(run, link, settings);
    EXPECT_TRUE(done.ok());
    return done.value();
  }
  std::vector<LiveRecord> records() {
    std::vector<LiveRecord> all;
    for (LiveRecord record; link.records.take(record); record = {}) all.push_back(std::move(record));
    return all;
  }

  Scene scene;
  LiveLink link;
  LiveRun run;
};

TEST(LiveLoop, TellsTheStartAndEachFrame) {
  Started setup;
  EXPECT_EQ(setup.go(5), 5U);
  const std::vector<LiveRecord> records = setup.records();
  ASSERT_EQ(records.size(), 6U);
  for (std::size_t i = 0; i < records.size(); ++i) {
    EXPECT_TRUE(records[i].has_frame);
    EXPECT_EQ(records[i].frame.facts.frame, i);
    EXPECT_EQ(records[i].frame.facts.measured, i > 0);
    EXPECT_EQ(records[i].frame.bodies.size(), 14U);
    EXPECT_EQ(records[i].frame.new_bodies.size(), i == 0 ? 14U : 0U);
    EXPECT_EQ(records[i].status.bodies, 9U);
    EXPECT_EQ(records[i].status.frame, i);
  }
}

TEST(LiveLoop, DoesWhatIsAskedBetweenFrames) {
  Started setup;
  setup.ask(SetDeadline{12.5});
  setup.ask(SetAlpha{0.05});
  setup.ask(SetWeight{&scheduler::Policy::closing, 3});
  setup.ask(SetPolicy{scheduler::PolicyKind::Fifo});
  setup.go(1);
  const LiveStatus status = setup.records().back().status;
  EXPECT_EQ(status.deadline_ms, 12.5);
  EXPECT_EQ(status.alpha, 0.05);
  EXPECT_EQ(status.policy.closing, 3);
  EXPECT_EQ(status.policy.kind, scheduler::PolicyKind::Fifo);
  EXPECT_EQ(setup.run.scene_run().world().settings().alpha, 0.05);
}

TEST(LiveLoop, LooksFromWhereAndToWhereItIsAsked) {
  Started setup;
  setup.go(1);
  const std::array<float, 3> before = setup.records().back().frame.facts.gaze;
  setup.ask(SetView{std::nullopt, Vec3(0, 1, 0)});
  setup.go(1);
  EXPECT_EQ(setup.records().back().frame.facts.gaze, (std::array<float, 3>{0, 1, 0}));
  View camera;
  camera.present = true;
  camera.position_m = {1, 2, 3};
  camera.forward = {0, 0, -1};
  camera.up = {0, 1, 0};
  camera.gaze = camera.forward;
  setup.ask(SetView{camera, std::optional<Vec3>()});
  setup.go(1);
  const capture::FrameFacts seen = setup.records().back().frame.facts;
  EXPECT_EQ(seen.position_m, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(seen.gaze, (std::array<float, 3>{0, 0, -1}));
  setup.ask(SetView{std::optional<View>(), std::nullopt});
  setup.go(1);
  EXPECT_EQ(setup.records().back().frame.facts.gaze, before) << "that of the scene again";
}

TEST(LiveLoop, PoursBodiesInAndTakesTheLastAway) {
  Started setup;
  setup.ask(SetBodies{12});
  setup.go(1);
  EXPECT_EQ(setup.records().back().status.bodies_asked, 12U);
  setup.go(10);
  std::vector<LiveRecord> records = setup.records();
  EXPECT_EQ(records.back().status.bodies, 12U);
  EXPECT_EQ(records.back().frame.bodies.size(), 17U);
  setup.ask(PourBodies{2});
  setup.ask(PourBodies{1});
  setup.go(10);
  EXPECT_EQ(setup.records().back().status.bodies, 15U);
  setup.ask(SetBodies{4});
  setup.go(1);
  records = setup.records();
  EXPECT_EQ(records.back().status.bodies, 4U);
  EXPECT_EQ(records.back().frame.bodies.back().number, 8U) << "the first stay";
}

TEST(LiveLoop, BodiesThatLeaveByThemselvesAreNotTakenAwayOnceMore) {
  Started setup(
      R"({"name": "s", "dt_s": 0.01, "materials": {"wood": {}}, "shapes": {"ball": {"sphere": {"radius_m": 0.1}}},
    "generators": [{"stream": {"shape": "ball", "material": "wood", "per_second": 1e6, "total": 1200, "life_s": 0.05,
                               "region_min_m": [-50, -50, 0], "region_max_m": [50, 50, 50]}}]})");
  setup.go(4);
  ASSERT_EQ(setup.records().back().status.bodies, 1200U);
  // As many as leave at once, and then the others at the end of their time.
  setup.ask(SetBodies{0});
  setup.go(1);
  ASSERT_EQ(setup.records().back().status.bodies, 200U);
  setup.go(2);
  const LiveStatus status = setup.records().back().status;
  EXPECT_EQ(status.bodies, 0U);
  EXPECT_EQ(status.bodies_asked, 0U);
}

TEST(LiveLoop, APausedRunDoesTheStepsThatAreAskedFor) {
  Started setup;
  setup.ask(SetPaused{true});
  const auto stops = [&](int look) {
    if (look == 2) setup.ask(StepFrames{2});
    return look > 6;
  };
  EXPECT_EQ(setup.go(100, stops), 2U);
  const std::vector<LiveRecord> records = setup.records();
  EXPECT_TRUE(records.back().status.paused);
  EXPECT_EQ(records.back().status.frame, 2U);
  EXPECT_FALSE(records.back().has_frame);
  setup.ask(SetPaused{false});
  EXPECT_EQ(setup.go(3), 3U);
}

TEST(LiveLoop, StartsTheSceneAgainWithWhatWasSet) {
  Started setup;
  setup.ask(SetWeight{&scheduler::Policy::closing, 3});
  setup.ask(PourBodies{3});
  setup.go(10);
  setup.records();
  setup.ask(StartAgain{});
  setup.go(2);
  const std::vector<LiveRecord> records = setup.records();
  EXPECT_EQ(records.back().run, 2U);
  EXPECT_EQ(records.back().frame.facts.frame, 2U);
  EXPECT_EQ(records.back().status.bodies, 9U);
  EXPECT_EQ(records.back().status.policy.closing, 3);
  // The start itself is told.
  EXPECT_EQ(records[records.size() - 3].frame.facts.frame, 0U);
  EXPECT_EQ(records[records.size() - 3].frame.new_bodies.size(), 14U);
}

// No machine does anything in a tenth of a microsecond.
TEST(LiveLoop, AStepThatDoesNotFitTakesSeveralFrames) {
  Started setup;
  setup.ask(SetDeadline{1e-4});
  // The last ball falls. It may be elsewhere only after a frame in which a step ended: a change of the World in between
  // would have ended it without one.
  double z_m = 1;
  std::size_t unfinished_frames = 0, moves = 0;
  const auto look_at = [&](const LiveRecord& record) {
    if (!record.has_frame) return;
    // All that is not asleep is held.
    const auto& counts = record.frame.facts.counts;
    const bool unfinished = counts[7] + counts[8] >= counts[0];
    const double now_m = record.frame.bodies[13].pose.position_m.z();
    unfinished_frames += unfinished ? 1 : 0;
    moves += now_m != z_m ? 1 : 0;
    EXPECT_TRUE(!unfinished || now_m == z_m) << "frame " << record.frame.facts.frame;
    z_m = now_m;
  };
  std::uint64_t asked = 0;
  const auto stops = [&](int) {
    for (const LiveRecord& record : setup.records()) look_at(record);
    const World& world = setup.run.scene_run().world();
    if (world.step_unfinished() && asked < 8 && unfinished_frames > 4 * asked) {
      setup.ask(SetAlpha{0.01 * static_cast<double>(++asked)});
      if (asked == 8) setup.ask(PourBodies{2});
      if (asked == 8) setup.ask(SetPaused{true});
    }
    return setup.run.status().paused && !world.step_unfinished();
  };
  setup.go(100'000, stops);
  EXPECT_GT(unfinished_frames, 28U);
  EXPECT_GT(moves, 0U);
  EXPECT_FALSE(setup.run.goes_on());
  EXPECT_EQ(setup.run.scene_run().world().settings().alpha, 0.08);
  EXPECT_EQ(setup.run.status().bodies, 9U) << "they come before the next step";
  EXPECT_EQ(setup.run.status().bodies_asked, 11U);
  setup.ask(SetPaused{false});
  setup.go(400, [&](int) {
    for (const LiveRecord& record : setup.records()) look_at(record);
    return false;
  });
  EXPECT_GT(setup.run.status().frames_a_step, 1.0);
  EXPECT_EQ(setup.run.status().bodies, 11U);
}

TEST(LiveLoop, RefusesTheOneWhoAsksAndChangesNothing) {
  Started setup(
      R"({"name": "s", "dt_s": 0.01, "materials": {"wood": {}}, "shapes": {"ball": {"sphere": {"radius_m": 1}}},
    "bodies": [{"shape": "ball", "material": "wood", "static": true}]})");
  setup.ask(PourBodies{5}, 42);
  setup.go(1);
  std::vector<LiveReply> replies;
  for (const LiveRecord& record : setup.records())
    replies.insert(replies.end(), record.replies.begin(), record.replies.end());
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_EQ(replies[0].client, 42U);
  EXPECT_EQ(replies[0].error, "s.json: has no dynamic bodies, so there is nothing to pour");
  Started full;
  full.ask(PourBodies{kMostLiveBodies}, 1);
  full.go(1);
  EXPECT_EQ(full.records().back().status.bodies_asked, 9U);
}

TEST(LiveLoop, NeverWaitsForANetworkThatTakesNothing) {
  Started setup;
  std::vector<LiveRecord> first;
  const auto stops = [&](int look) {
    if (look == 80) first = setup.records();
    return false;
  };
  EXPECT_EQ(setup.go(90, stops), 90U);
  EXPECT_EQ(first.size(), LiveLink::kRecordsWaiting);
  const std::vector<LiveRecord> later = setup.records();
  // Of the start and 80 frames before that look, those that found no room.
  const std::uint64_t missed = 81 - LiveLink::kRecordsWaiting;
  EXPECT_EQ(later.front().frame.facts.left_out, missed);
  EXPECT_EQ(later.back().status.left_out, missed);
  EXPECT_EQ(later.back().frame.facts.left_out, 0U);
}

TEST(LiveLoop, BodiesThatCameWhileNothingWasTakenAreToldLater) {
  Started setup;
  const auto stops = [&](int look) {
    if (look == 40) setup.ask(PourBodies{2});
    if (look == 60) setup.records();
    return false;
  };
  setup.go(70, stops);
  const std::vector<LiveRecord> later = setup.records();
  EXPECT_EQ(later.front().frame.new_bodies.size(), 2U);
}

}  // namespace
}  // namespace poise::app
