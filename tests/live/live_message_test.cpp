// SPDX-License-Identifier: MIT
#include "app/live/live_message.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <variant>

namespace poise::app {
namespace {

std::string refusal(const std::string& text) {
  const Result<LiveMessage> message = parse_live_message(text);
  return message ? "" : message.error().message;
}

template <class Message>
Message read(const std::string& text) {
  const Result<LiveMessage> message = parse_live_message(text);
  EXPECT_TRUE(message.ok()) << (message ? "" : message.error().message);
  return message ? std::get<Message>(message.value()) : Message{};
}

const std::string kCamera =
    R"("position_m": [1, 2, 3], "forward": [0, 1, 0], "up": [0, 0, 1], "vertical_fov_rad": 0.9, "aspect": 1.5)";

TEST(LiveMessage, EachKindIsReadWithItsValues) {
  EXPECT_EQ(read<SetDeadline>(R"({"do": "deadline", "ms": 7.5})").ms, 7.5);
  EXPECT_EQ(read<SetAlpha>(R"({"do": "alpha", "value": 0.01})").value, 0.01);
  const auto weight = read<SetWeight>(R"({"do": "weight", "cue": "closing", "value": 2})");
  EXPECT_EQ(weight.weight, &scheduler::Policy::closing);
  EXPECT_EQ(weight.value, 2);
  EXPECT_EQ(read<SetPolicy>(R"({"do": "policy", "name": "round-robin"})").kind, scheduler::PolicyKind::RoundRobin);
  EXPECT_EQ(read<SetBodies>(R"({"do": "bodies", "count": 0})").count, 0U);
  EXPECT_EQ(read<PourBodies>(R"({"do": "pour", "count": 50})").count, 50U);
  EXPECT_TRUE(read<SetPaused>(R"({"do": "pause", "on": true})").on);
  EXPECT_EQ(read<StepFrames>(R"({"do": "step", "count": 3})").count, 3U);
  EXPECT_EQ(read<FrameShown>(R"({"do": "shown", "number": 4000000000})").number, 4'000'000'000U);
  read<StartAgain>(R"({"do": "again"})");
}

TEST(LiveMessage, AViewSaysWhatChangesAndWhatGoesBack) {
  const auto nothing = read<SetView>(R"({"do": "view"})");
  EXPECT_FALSE(nothing.camera || nothing.gaze);
  const auto back = read<SetView>(R"({"do": "view", "camera": null, "gaze": null})");
  ASSERT_TRUE(back.camera && back.gaze);
  EXPECT_FALSE(*back.camera || *back.gaze);
  const auto view = read<SetView>(R"({"do": "view", "gaze": [0.6, 0.8, 0], "camera": {)" + kCamera + "}}");
  ASSERT_TRUE(view.camera && *view.camera && view.gaze && *view.gaze);
  EXPECT_TRUE((*view.camera)->present);
  EXPECT_EQ((*view.camera)->position_m, Vec3(1, 2, 3));
  EXPECT_EQ((*view.camera)->gaze, Vec3(0, 1, 0));
  EXPECT_NEAR((*view.gaze)->norm(), 1, 1e-15);
}

TEST(LiveMessage, IsRefusedWhereItIsNoMessage) {
  EXPECT_EQ(refusal(std::string(kMostMessageBytes + 1, ' ')), "message: 4097 bytes, must be at most 4096");
  EXPECT_NE(refusal("{").find("message: line 1, column 2: not valid JSON"), std::string::npos) << refusal("{");
  EXPECT_EQ(refusal("[1]"), "message: must be an object, is [1]");
  EXPECT_EQ(refusal("{}"), "message: do: missing, and it is required");
  EXPECT_EQ(
      refusal(R"({"do": "jump"})"),
      "message: do = \"jump\", must be deadline, alpha, weight, policy, bodies, pour, view, pause, step, again or "
      "shown");
  EXPECT_EQ(refusal(R"({"do": 3})").substr(0, 18), "message: do = 3, m");
  EXPECT_EQ(refusal(R"({"do": "again", "now": 1})"), "message: now: no such field");
  EXPECT_NE(refusal(R"({"do": "again", "do": "again"})").find("is given twice"), std::string::npos);
}

TEST(LiveMessage, IsRefusedWithFieldValueAndRule) {
  const std::pair<const char*, const char*> wrong[] = {
      {R"({"do": "deadline"})", "message: ms: missing, and it is required"},
      {R"({"do": "deadline", "ms": 0})", "message: ms = 0, must be > 0"},
      {R"({"do": "deadline", "ms": 10001})", "message: ms = 10001, must be <= 10000"},
      {R"({"do": "deadline", "ms": "8"})", "message: ms = \"8\", must be a number"},
      {R"({"do": "alpha", "value": 0})", "message: value = 0, must be >= 1e-05"},
      {R"({"do": "alpha", "value": 0.6})", "message: value = 0.6, must be <= 0.5"},
      {R"({"do": "weight", "cue": "closing"})", "message: value: missing, and it is required"},
      {R"({"do": "weight", "value": 1})", "message: cue: missing, and it is required"},
      {R"({"do": "weight", "cue": "closing", "value": -1})", "message: value = -1, must be >= 0"},
      {R"({"do": "bodies", "count": 1.5})", "message: count = 1.5, must be a whole number from 0 to 100000"},
      {R"({"do": "bodies", "count": 100001})", "message: count = 100001, must be a whole number from 0 to 100000"},
      {R"({"do": "pour", "count": 0})", "message: count = 0, must be a whole number from 1 to 10000"},
      {R"({"do": "pause", "on": 1})", "message: on = 1, must be true or false"},
      {R"({"do": "step", "count": 1001})", "message: count = 1001, must be a whole number from 1 to 1000"},
      {R"({"do": "shown", "number": -1})",
       "message: number = -1, must be a whole number from 0 to 18446744073709551615"},
      {R"({"do": "view", "gaze": [1, 1, 0]})", "message: gaze = [1, 1, 0], must have length 1"},
      {R"({"do": "view", "gaze": [2, 0, 0]})", "message: gaze[0] = 2, must be <= 1"},
      {R"({"do": "view", "gaze": [1, 0]})", "message: gaze = [1, 0], must be a list of 3 numbers"},
      {R"({"do": "view", "camera": 1})", "message: camera = 1, must be an object"},
      {R"({"do": "view", "camera": {}})", "message: camera.position_m: missing, and it is required"},
  };
  for (const auto& [text, message] : wrong) EXPECT_EQ(refusal(text), message);
  EXPECT_EQ(
      refusal(R"({"do": "weight", "cue": "closeness", "value": 1})").find("message: cue = \"closeness\", must be"), 0U);
  EXPECT_EQ(refusal(R"({"do": "policy", "name": "custom"})").find("message: name = \"custom\", must be"), 0U);
}

TEST(LiveMessage, ACameraIsRefusedWhereItSeesNothing) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string camera = kCamera;
    camera.replace(camera.find(from), from.size(), to);
    return refusal(R"({"do": "view", "camera": {)" + camera + "}}");
  };
  EXPECT_EQ(with("[0, 0, 1]", "[0, -1, 0]"), "message: camera.up: must not be parallel to camera.forward");
  EXPECT_EQ(with("[0, 1, 0]", "[0, 0, 0]"), "message: camera.forward = [0, 0, 0], must have length 1");
  EXPECT_EQ(with("0.9", "0"), "message: camera.vertical_fov_rad = 0, must be > 0");
  EXPECT_EQ(with("0.9", "3.15"), "message: camera.vertical_fov_rad = 3.15, must be <= 3.14");
  // What a step would refuse.
  EXPECT_EQ(with("0.9", "3.1415925"), "message: camera.vertical_fov_rad = 3.1415925, must be <= 3.14");
  EXPECT_EQ(with("[0, 0, 1]", "[0, 0.9999994, 0.0011]"), "message: camera.up: must not be parallel to camera.forward");
  EXPECT_EQ(with("1.5", "0"), "message: camera.aspect = 0, must be >= 0.01");
  EXPECT_EQ(with("[1, 2, 3]", "[1, 2, 3e9]"), "message: camera.position_m[2] = 3e9, must be <= 1e+09");
}

}  // namespace
}  // namespace poise::app
