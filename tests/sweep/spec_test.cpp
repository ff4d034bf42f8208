// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene/temporary_folder.h"
#include "sweep/specs.h"
#include "sweep/sweep_spec.h"

namespace poise::testing {
namespace {

using Json = nlohmann::ordered_json;

TEST(SweepSpec, HasWhatTheFileSays) {
  const sweep::SweepSpec spec = spec_of(Json::parse(R"({
    "schema": "poise.sweep/1", "name": "mine", "description": "why", "scenes": ["jacks", "./own.json"],
    "settings": {"paced": true, "frames": 1e2, "weight.closing": 2},
    "axes": {"bodies": [250, 500.0], "policy": ["perceptual", "mine.json"], "deadline_ms": [2.5]},
    "seeds": [7, 18446744073709551615], "repeats": 3,
    "requirements": ["miss_rate <= 0.01", "frame_ms.p99 < 16"], "frontier": {"largest": "bodies", "against": "deadline_ms"},
    "figures": ["frame_ms.p99"], "trial": {"cores": 2, "time_limit_s": 90}})"));
  EXPECT_EQ(spec.name, "mine");
  EXPECT_EQ(spec.scenes, (std::vector<std::string>{"jacks", "./own.json"}));
  ASSERT_EQ(spec.settings.size(), 3U);
  EXPECT_EQ(spec.settings[0].text, "true");
  EXPECT_EQ(spec.settings[1].text, "100") << "numbers are written in one way";
  EXPECT_EQ(spec.settings[2].name, "weight.closing");
  ASSERT_EQ(spec.axes.size(), 4U);
  EXPECT_EQ(spec.axes[0].values[1].text, "500");
  EXPECT_EQ(spec.axes[0].values[1].number, 500);
  EXPECT_EQ(spec.axes[2].values[0].text, "2.5");
  EXPECT_EQ(spec.axes[3].name, "seed");
  EXPECT_EQ(spec.axes[3].values[1].text, "18446744073709551615") << "a seed has more digits than a double";
  EXPECT_EQ(spec.repeats, 3U);
  EXPECT_EQ(spec.requirements.size(), 2U);
  EXPECT_EQ(spec.frontier->against, "deadline_ms");
  EXPECT_EQ(spec.cores, 2U);
  EXPECT_EQ(spec.time_limit_s, 90);
}

TEST(SweepSpec, NeedsOnlyItsSchemaAndAScene) {
  const sweep::SweepSpec spec = spec_of({{"schema", "poise.sweep/1"}, {"scenes", {"jacks"}}});
  EXPECT_EQ(spec.name, "s");
  EXPECT_EQ(spec.repeats, 1U);
  EXPECT_EQ(spec.time_limit_s, 3600);
  EXPECT_TRUE(spec.axes.empty());
}

struct RefusedSpec {
  std::string members;  ///< besides the schema and a scene, unless they are in it
  std::string message;
};

TEST(SweepSpec, RefusesWithPlaceValueAndRule) {
  const std::vector<RefusedSpec> cases{
      {R"("axes": {"bodis": [1]})", "s.json: axes.bodis: no such setting of a run; did you mean \"bodies\"?"},
      {R"("axes": {"json": [1]})", "axes.json: no such setting of a run"},
      {R"("axes": {"affinity": ["0"]})", "axes.affinity: no such setting of a run"},
      {R"("axes": {"weight.": [1]})", "no such setting of a run"},
      {R"("axes": {"bodies": 5})", "axes.bodies = 5, must be a list of values that is not empty"},
      {R"("axes": {"bodies": []})", "must be a list of values that is not empty"},
      {R"("axes": {"bodies": ["many"]})", "axes.bodies[0] = \"many\", must be a number"},
      {R"("axes": {"bodies": [250, 500, 250.0]})", "axes.bodies[2] = 250.0, is given twice"},
      {R"("axes": {"paced": [1]})", "axes.paced[0] = 1, must be true or false"},
      {R"("axes": {"policy": [""]})", "axes.policy[0] = \"\", must be a text that is not empty"},
      {R"("axes": {"max_level": [true]})", "axes.max_level[0] = true, must be a number or a text"},
      {R"("axes": [1])", "axes = [1], must be an object"},
      {R"("settings": [1])", "must be an object"},
      {R"("settings": {"clok": "work"})", "settings.clok: no such setting of a run; did you mean \"clock\"?"},
      {R"("settings": {"frames": "10"})", "settings.frames = \"10\", must be a number"},
      {R"("settings": {"bodies": 5}, "axes": {"bodies": [5]})", "axes.bodies: is in settings too"},
      {R"("axes": {"seed": [1]}, "seeds": [2])", "seeds: is given twice"},
      {R"("seeds": 3)", "seeds = 3, must be a list of values that is not empty"},
      {R"("repeats": 0)", "repeats = 0, must be a whole number from 1 to 10000"},
      {R"("repeats": 2.5)", "repeats = 2.5, must be a whole number"},
      {R"("requirements": "miss_rate < 1")", "must be a list of texts"},
      {R"("requirements": ["miss_rat < 1"])",
       R"(requirements[0]: "miss_rat", no such figure of a run; did you mean "miss_rate"?)"},
      {R"("requirements": ["miss_rate <"])", "requirements[0]: "},
      {R"("figures": ["frame_ms.p98"])", "figures[0]: \"frame_ms.p98\", no such figure of a run"},
      {R"("figures": [""])", "figures[0] = \"\", must be a text that is not empty"},
      {R"("axes": {"bodies": [1, 2]}, "frontier": {"largest": "bodies"}, "requirements": ["miss_rate < 1"])",
       "frontier.against: missing, and it is required"},
      {R"("axes": {"bodies": [1, 2]}, "frontier": {"largest": "bodies", "against": "bodies"}, "requirements": ["miss_rate < 1"])",
       "frontier.against: must be another axis than `largest`"},
      {R"("axes": {"bodies": [1, 2]}, "frontier": {"largest": "bodies", "against": "threads"}, "requirements": ["miss_rate < 1"])",
       "frontier.against = \"threads\", must be the name of an axis"},
      {R"("axes": {"bodies": [1, 2]}, "seeds": [1, 2], "frontier": {"largest": "bodies", "against": "seed"}, "requirements": ["miss_rate < 1"])",
       "frontier.against = \"seed\", must be the name of an axis other than seed"},
      {R"("axes": {"bodies": [1], "policy": ["fifo"]}, "frontier": {"largest": "policy", "against": "bodies"}, "requirements": ["miss_rate < 1"])",
       "frontier.largest = \"policy\", must be an axis of numbers"},
      {R"("axes": {"bodies": [1], "threads": [1]}, "frontier": {"largest": "bodies", "against": "threads"})",
       "frontier: needs `requirements`"},
      {R"("trial": {"cores": 0})", "trial.cores = 0, must be a whole number from 1 to 256"},
      {R"("trial": {"time_limit_s": 0})", "trial.time_limit_s = 0, must be > 0"},
      {R"("trial": {"time_limit": 5})", "trial.time_limit: no such field; did you mean \"time_limit_s\"?"},
      {R"("name": "")", "name = \"\", must not be empty"},
      {R"("scene": "jacks")", "scene: no such field; did you mean \"scenes\"?"},
      {R"("axes": {"bodies": [1,2,3,4,5,6,7,8,9,10,11]}, "repeats": 10000)", "110000 trials, must be at most 100000"},
  };
  for (const RefusedSpec& c : cases) {
    const std::string text = R"({"schema": "poise.sweep/1", "scenes": ["jacks"], )" + c.members + "}";
    EXPECT_NE(spec_refusals(text).find(c.message), std::string::npos) << text << "\n" << spec_refusals(text);
  }
}

// Each trial has every setting: neither their number nor their length may grow with the file.
TEST(SweepSpec, LimitsWhatEachTrialHolds) {
  std::string weights;
  for (std::size_t i = 0; i < sweep::kMostSettings; ++i)
    weights += (i == 0 ? "\"weight.c" : ", \"weight.c") + std::to_string(i) + "\": 1";
  const std::string begin = R"({"schema": "poise.sweep/1", "scenes": ["a"], "settings": {)";
  EXPECT_EQ(spec_refusals(begin + weights + "}}"), "accepted");
  EXPECT_NE(spec_refusals(begin + weights + R"(, "frames": 1}})").find("settings: 65 settings, must be at most 64"),
            std::string::npos);
  EXPECT_NE(spec_refusals(begin + weights + R"(}, "axes": {"frames": [1]}})").find("axes: 65 settings"),
            std::string::npos);
  const std::string longest(sweep::kLongestSetting, 'p');
  const auto with_policy = [&](const std::string& policy) { return begin + R"("policy": ")" + policy + "\"}}"; };
  EXPECT_EQ(spec_refusals(with_policy(longest)), "accepted");
  EXPECT_NE(spec_refusals(with_policy(longest + "p")).find("must have at most 4096 bytes"), std::string::npos);
  EXPECT_NE(spec_refusals(R"({"schema": "poise.sweep/1", "scenes": [")" + longest + "p\"]}")
                .find("must have at most 4096 bytes"),
            std::string::npos);
}

TEST(SweepSpec, RefusesAFileOfAnotherKind) {
  EXPECT_NE(spec_refusals("[1]").find("s.json: must be an object"), std::string::npos);
  EXPECT_NE(spec_refusals("{").find("s.json:"), std::string::npos);
  EXPECT_NE(spec_refusals("{}").find("schema: missing, and it is required"), std::string::npos);
  EXPECT_NE(spec_refusals("{}").find("scenes: missing, and it is required"), std::string::npos);
  EXPECT_NE(spec_refusals(R"({"schema": "poise.scene/1", "scenes": ["a"]})").find("must be \"poise.sweep/1\""),
            std::string::npos);
  EXPECT_NE(spec_refusals(R"({"schema": "poise.sweep/1", "scenes": []})")
                .find("scenes = [], must be a list of texts that is not empty"),
            std::string::npos)
      << spec_refusals(R"({"schema": "poise.sweep/1", "scenes": []})");
  EXPECT_NE(
      spec_refusals(R"({"schema": "poise.sweep/1", "scenes": ["a", "a"]})").find("scenes[1] = \"a\", is given twice"),
      std::string::npos);
}

// One mistake of every kind at once: each is told.
TEST(SweepSpec, TellsOfEveryMistakeAtOnce) {
  const std::string all = spec_refusals(
      R"({"schema": "poise.sweep/1", "scenes": ["a"], "repeats": 0, "seeds": 1, "trial": 5, "axes": {"x": [1]}})");
  for (const char* place : {"repeats", "seeds", "trial", "axes.x"})
    EXPECT_NE(all.find(place), std::string::npos) << place << "\n" << all;
}

TEST(SweepDocs, HaveAnExampleThatIsRead) {
  const std::string text = contents(POISE_SOURCE_DIR "/docs/sweep.md");
  const std::string begin = "```jsonc\n";
  const std::size_t at = text.find(begin);
  ASSERT_NE(at, std::string::npos);
  const std::size_t from = at + begin.size();
  EXPECT_EQ(spec_refusals(text.substr(from, text.find("```", from) - from)), "accepted");
  for (const sweep::RunSetting& setting : sweep::run_settings())
    EXPECT_NE(text.find(std::string(setting.name)), std::string::npos) << setting.name;
}

TEST(SweepSchema, NamesTheMembersAndSettingsThatTheReaderKnows) {
  const Json schema = Json::parse(contents(POISE_SOURCE_DIR "/docs/sweep.schema.json"));
  for (const auto& [member, unused] : schema.at("properties").items()) {
    const Json odd{{member, nullptr}};
    EXPECT_EQ(spec_refusals(odd.dump()).find(member + ": no such field"), std::string::npos) << member;
  }
  EXPECT_EQ(schema.at("properties").size(), 12U);
  const Json& settings = schema.at("$defs").at("settings").at("properties");
  EXPECT_EQ(settings.size(), sweep::run_settings().size());
  for (const sweep::RunSetting& setting : sweep::run_settings())
    EXPECT_TRUE(settings.contains(std::string(setting.name))) << setting.name;
  for (const char* object : {"trial", "frontier"}) {
    for (const auto& [member, unused] : schema.at("properties").at(object).at("properties").items()) {
      const Json odd{{object, {{member, nullptr}}}};
      EXPECT_EQ(spec_refusals(odd.dump()).find(member + ": no such field"), std::string::npos) << member;
    }
  }
}

}  // namespace
}  // namespace poise::testing
