// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scene/field_reader.h"
#include "scene/scene_text.h"

namespace poise::testing {
namespace {

std::vector<std::string> errors_of(const std::string& text) {
  std::vector<std::string> errors;
  const Result<Scene> scene = parse_scene(text, "s.json", "/nowhere", &errors);
  EXPECT_EQ(!scene, !errors.empty());
  if (!scene && !errors.empty()) {
    EXPECT_EQ(scene.error().message, errors.front());
  }
  return errors;
}

TEST(SceneProblems, AreAllToldInTheOrderOfReading) {
  const std::vector<std::string> errors = errors_of(R"({
    "name": "x", "dt_s": 2, "frams": 3, "max_level": "polygon",
    "materials": {"m": {"restitution": 2, "friction": -1}},
    "shapes": {"ball": {"sphere": {"radius_m": -1}}, "floor": {"plane": {"normal": [0, 0, 0]}}},
    "bodies": [{"shape": "bal", "material": "m"}, {"shape": "floor", "material": "n"},
               {"shape": "ball", "material": "m", "mass_kg": "heavy", "name": 3}],
    "generators": [{"stream": {"shape": "ball", "material": "m", "per_second": -1, "total": 3}}]})");
  const std::vector<std::string> expected = {
      "s.json: frams: no such field; did you mean \"frames\"?",
      "s.json: dt_s = 2, must be <= 1",
      "s.json: max_level = \"polygon\", must be a whole number from 0 to 6, or \"polygons\"; did you mean "
      "\"polygons\"?",
      "s.json: materials.m.restitution = 2, must be <= 1",
      "s.json: materials.m.friction = -1, must be >= 0",
      "s.json: shapes.ball.sphere.radius_m = -1, must be >= 1e-09",
      "s.json: shapes.floor.plane.normal = [0, 0, 0], must not be zero",
      "s.json: bodies[0].shape = \"bal\", must be the name of a shape; did you mean \"ball\"?",
      "s.json: bodies[1].material = \"n\", must be the name of a material; did you mean \"m\"?",
      "s.json: bodies[1].static: must be true, since the shape is a plane",
      "s.json: bodies[2].name = 3, must be a text",
      "s.json: bodies[2].mass_kg = \"heavy\", must be a number",
      "s.json: generators[0].stream.per_second = -1, must be > 0",
      "s.json: generators[0].stream.region_min_m: missing, and it is required",
      "s.json: generators[0].stream.region_max_m: missing, and it is required"};
  EXPECT_EQ(errors, expected);
}

TEST(SceneProblems, OfOneMistakeAreToldOnce) {
  const auto one = [](const std::string& text) { EXPECT_EQ(errors_of(text).size(), 1U) << text; };
  one(scene_text(R"("camera": {"position_m": "here", "look_at_m": [0, 0, 0]}, )"));
  one(scene_text(R"("tray": 3, )"));
  one(scene_text(R"("host_work": {"load_ms": "much", "jitter_ms": 3}, )"));
  one(scene_text(R"("generators": 3, )", "[]"));
  one(scene_text("", R"([{"shape": "none", "material": "hard", "orientation_wxyz": [1, 0, 0, 0]}])"));
  one(scene_text("", R"([{"shape": "ball", "material": "hard", "orientation_wxyz": ["a", 0, 0, 0]}])"));
  one(R"({"name": "x", "dt_s": 1, "materials": [], "shapes": {"s": {"sphere": {"radius_m": 1}}},
          "bodies": [{"shape": "s", "material": "m"}]})");
}

TEST(SceneProblems, BeyondTenThousandAreCounted) {
  std::string bodies = "[";
  for (int i = 0; i < 12'000; ++i) bodies += std::string(i > 0 ? ", " : "") + R"({"shape": "bal", "material": "hard"})";
  const std::vector<std::string> errors = errors_of(scene_text("", bodies + "]"));
  ASSERT_EQ(errors.size(), 10'001U);
  EXPECT_EQ(errors.back(), "s.json: and 2000 more");
}

TEST(SceneProblems, SuggestNoMoreThanTheirWorkAllows) {
  // 10,000 shapes and 10,000 wrong names are 10^8 comparisons of names of 40 letters.
  std::string shapes, bodies;
  const std::string tail(36, 'x');
  for (int i = 0; i < 10'000; ++i) {
    const std::string number = std::to_string(10'000 + i);
    shapes += std::string(i > 0 ? ", " : "") + "\"" + number + tail + R"(": {"sphere": {"radius_m": 1}})";
    bodies += std::string(i > 0 ? ", " : "") + R"({"material": "m", "shape": ")" + number + tail + "y\"}";
  }
  const std::vector<std::string> errors = errors_of(R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": {)" +
                                                    shapes + "}, \"bodies\": [" + bodies + "]}");
  ASSERT_EQ(errors.size(), 10'000U);
  EXPECT_NE(errors.front().find("did you mean"), std::string::npos) << errors.front();
  EXPECT_EQ(errors.back().find("did you mean"), std::string::npos) << errors.back();
}

TEST(NearestName, KeepsToItsLimitOfWork) {
  std::uint64_t letters = 30;
  EXPECT_EQ(io::nearest_name("mass", {"density", "mas"}, &letters), "");
  letters = 1000;
  EXPECT_EQ(io::nearest_name("mass", {"density", "mas"}, &letters), "mas");
  EXPECT_EQ(letters, 1000U - 29U - 13U);
  EXPECT_EQ(io::nearest_name("gravty_mps2", {"gaze_px", "gravity_mps2"}), "gravity_mps2");
  EXPECT_EQ(io::nearest_name("zebra", {"gaze_px", "gravity_mps2"}), "");
}

TEST(ScenePolicy, TakesEveryWeightAndParameterThatAPolicyHas) {
  for (const auto& fields : {scheduler::policy_weights(), scheduler::policy_parameters()}) {
    for (const scheduler::PolicyField& field : fields) {
      const std::string name(field.name);
      const Result<Scene> scene =
          parse(scene_text("\"policy\": {\"" + name + "\": " + std::to_string(field.most) + "}, "));
      ASSERT_TRUE(scene) << scene.error().message;
      EXPECT_EQ(scene.value().policy.*field.value, field.most) << name;
      EXPECT_NE(
          refusal(scene_text("\"policy\": {\"" + name + "\": -1}, ")).find("policy." + name + " = -1, must be >="),
          std::string::npos);
    }
  }
  for (const scheduler::PolicyCount& field : scheduler::policy_counts()) {
    const std::string name(field.name);
    const Result<Scene> scene = parse(scene_text("\"policy\": {\"" + name + "\": 7}, "));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene.value().policy.*field.value, 7U) << name;
    EXPECT_NE(refusal(scene_text("\"policy\": {\"" + name + "\": 0}, ")).find("must be a whole number from 1"),
              std::string::npos);
  }
}

TEST(ScenePolicy, RefusesWhatIsForHostsAndWhatItDoesNotKnow) {
  EXPECT_EQ(
      refusal(scene_text(R"("policy": {"kind": "custom"}, )")),
      "s.json: policy.kind = \"custom\", is for programs that hand the World a function of their own; a scene file "
      "may say perceptual, fifo, random, round-robin, size, deepest, equal-levels");
  EXPECT_EQ(refusal(scene_text(R"("policy": {"kind": "fifi"}, )")),
            "s.json: policy.kind = \"fifi\", must be perceptual, fifo, random, round-robin, size, deepest or "
            "equal-levels; did you mean \"fifo\"?");
  EXPECT_EQ(refusal(scene_text(R"("policy": {"front_grwth": 1}, )")),
            "s.json: policy.front_grwth: no such field; did you mean \"front_growth\"?");
}

}  // namespace
}  // namespace poise::testing
