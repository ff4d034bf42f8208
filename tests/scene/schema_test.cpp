// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "poise/scheduler/cues.h"
#include "scene/scene_text.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

json schema() { return json::parse(contents(POISE_SOURCE_DIR "/docs/scene.schema.json"), nullptr, false); }

/// The message for a scene whose object at `where` has only the member `key`, with a value of a type that no field
/// accepts.
std::string message_with(const std::string& where, const std::string& key) {
  json scene = {{"name", "x"},
                {"dt_s", 1},
                {"materials", {{"m", json::object()}}},
                {"shapes", {{"s", {{"sphere", {{"radius_m", 1}}}}}}}};
  const json odd = {{key, nullptr}};
  const json generator = {{where, odd}};
  if (where == "gaze" || where == "gaze_key") scene["camera"] = {{"position_m", {0, 0, 0}}, {"look_at_m", {1, 0, 0}}};
  if (where == "gaze") scene["gaze"] = odd;
  if (where == "gaze_key") scene["gaze"] = {{"path", json::array({odd})}};
  if (where == "key") scene["camera"] = {{"path", json::array({odd, odd})}};
  if (where == "blocks") {
    scene["generators"] = json::array(
        {{{"grid", {{"shape", "s"}, {"material", "m"}, {"spacing_m", 1}, {"count", {1, 1, 1}}, {"blocks", odd}}}}});
  }
  if (where == "top") scene[key] = nullptr;
  if (where == "material") scene["materials"]["m"] = odd;
  if (where == "body") scene["bodies"] = json::array({odd});
  if (where == "camera" || where == "policy" || where == "tray") scene[where] = odd;
  if (where == "grid" || where == "stream") scene["generators"] = json::array({generator});
  if (where == "sphere" || where == "plane" || where == "mesh" || where == "spheres" || where == "tree")
    scene["shapes"]["s"] = generator;
  return refusal(scene.dump());
}

TEST(SceneSchema, NamesOnlyMembersThatTheReaderKnows) {
  const json top = schema().at("properties");
  const json shapes = top.at("shapes").at("additionalProperties").at("properties");
  const json generators = top.at("generators").at("items").at("properties");
  const std::pair<std::string, json> objects[] = {
      {"top", top},
      {"material", top.at("materials").at("additionalProperties").at("properties")},
      {"body", top.at("bodies").at("items").at("properties")},
      {"camera", top.at("camera").at("properties")},
      {"key", top.at("camera").at("properties").at("path").at("items").at("properties")},
      {"gaze", top.at("gaze").at("properties")},
      {"gaze_key", top.at("gaze").at("properties").at("path").at("items").at("properties")},
      {"policy", top.at("policy").at("properties")},
      {"tray", top.at("tray").at("properties")},
      {"sphere", shapes.at("sphere").at("properties")},
      {"plane", shapes.at("plane").at("properties")},
      {"mesh", shapes.at("mesh").at("properties")},
      {"spheres", shapes.at("spheres").at("properties")},
      {"tree", shapes.at("tree").at("properties")},
      {"grid", generators.at("grid").at("properties")},
      {"blocks", generators.at("grid").at("properties").at("blocks").at("properties")},
      {"stream", generators.at("stream").at("properties")}};
  std::size_t members = 0;
  for (const auto& [where, properties] : objects) {
    for (const auto& [key, unused] : properties.items()) {
      const std::string message = message_with(where, key);
      EXPECT_EQ(message.find("no such field"), std::string::npos) << where << ": " << message;
      EXPECT_NE(message, "accepted") << where << "." << key;
      ++members;
    }
    EXPECT_NE(message_with(where, "zebra").find("zebra: no such field"), std::string::npos) << where;
  }
  EXPECT_GE(members, 80U);
}

TEST(CuesPage, NamesEveryCueWithUnitAndSource) {
  const std::string page = contents(POISE_SOURCE_DIR "/docs/cues.md");
  for (const scheduler::Cue* cue : scheduler::cue_list()) {
    const std::string row = "| `" + std::string(cue->name) + "` | " + std::string(cue->unit);
    const std::size_t at = page.find(row);
    ASSERT_NE(at, std::string::npos) << row;
    const std::string line = page.substr(at, page.find('\n', at) - at);
    EXPECT_NE(line.find("| " + std::string(cue->source) + " |"), std::string::npos) << line;
  }
}

TEST(SceneSchema, KnowsEveryMemberThatTheShippedScenesUse) {
  const json properties = schema().at("properties");
  for (const auto& entry : std::filesystem::directory_iterator(POISE_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".json") continue;
    const json scene = json::parse(contents(entry.path()), nullptr, false, true);
    for (const auto& [key, unused] : scene.items()) EXPECT_TRUE(properties.contains(key)) << entry.path() << " " << key;
  }
}

TEST(SceneFormat, HasAnExampleThatIsRead) {
  const std::string text = contents(POISE_SOURCE_DIR "/docs/scene-format.md");
  const std::string begin = "```jsonc\n";
  const std::size_t at = text.find(begin);
  ASSERT_NE(at, std::string::npos);
  const std::string example = text.substr(at + begin.size(), text.find("```", at + begin.size()) - at - begin.size());
  const Result<Scene> scene = parse(example);
  EXPECT_TRUE(scene) << scene.error().message;
}

}  // namespace
}  // namespace poise::testing
