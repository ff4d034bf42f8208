// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/files/output_files.h"
#include "poise/result.h"
#include "poise/scene/scene.h"

namespace poise::app {

/// A scene as text, before it is parsed.
struct SceneText {
  std::string text;
  std::string name;            ///< for messages: the file, or `standard input`
  std::filesystem::path base;  ///< what its files are relative to
};

/// The text that SCENE means on the command line of `command`: a scene file, a scene that ships, or for `-` the
/// standard input, whose files are relative to the current folder. Where nothing comes from there for a second, a line
/// on stderr says so unless `quiet`. Refused as find_scene and read_scene do.
Result<SceneText> read_scene_argument(const std::string& scene, std::string_view command, bool quiet);

/// parse_scene; `errors` gets every refusal, one line each.
Result<Scene> parse_scene_text(const SceneText& scene, std::vector<std::string>& errors);

/// Refuses an output into a file that the scene names.
Status check_scene_files(std::initializer_list<NamedFile> outputs, const Scene& scene);

}  // namespace poise::app
