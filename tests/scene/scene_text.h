// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "poise/scene/scene.h"

namespace poise::testing {

/// A scene with `members` (JSON, each with a comma after it) before a ball, a floor and what the format requires.
inline std::string scene_text(const std::string& members,
                              const std::string& bodies = R"([{"shape": "ball", "material": "hard"}])") {
  return "{" + members + R"("name": "test", "dt_s": 0.01, "materials": {"hard": {"restitution": 0.5}},
    "shapes": {"ball": {"sphere": {"radius_m": 0.5}}, "floor": {"plane": {"normal": [0, 0, 1]}}}, "bodies": )" +
         bodies + "}";
}

inline Result<Scene> parse(const std::string& text) { return parse_scene(text, "s.json", "/nowhere"); }

inline std::string refusal(const std::string& text) {
  const Result<Scene> scene = parse(text);
  return scene ? "accepted" : scene.error().message;
}

/// A run on the calling thread alone.
inline SceneRunOptions serial() {
  SceneRunOptions options;
  options.world.executor = ExecutorKind::Serial;
  options.world.threads = 1;
  return options;
}
inline SceneRun run_of(const Scene& scene, const SceneRunOptions& options = serial()) {
  Result<SceneRun> run = SceneRun::create(scene, options);
  EXPECT_TRUE(run) << run.error().message;
  return std::move(run).value();
}

}  // namespace poise::testing
