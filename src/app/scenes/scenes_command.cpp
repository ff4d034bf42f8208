// SPDX-License-Identifier: MIT
#include "app/scenes/scenes_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/files/scene_files.h"
#include "app/process/exit_codes.h"
#include "app/process/standard_streams.h"
#include "poise/scene/scene.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

struct Listed {
  std::string name;
  std::string file;
  std::uint64_t bodies = 0;
  std::string description;
};

std::string as_table(const std::vector<Listed>& scenes) {
  std::size_t widest = 5;
  for (const Listed& scene : scenes) widest = std::max(widest, scene.name.size());
  std::string text = fmt::format("{:<{}}  bodies  what it shows\n", "scene", widest);
  for (const Listed& scene : scenes) {
    text += fmt::format("{:<{}}  {:>6}  {}\n", scene.name, widest, scene.bodies, scene.description);
  }
  return text;
}

std::string as_json(const std::vector<Listed>& scenes) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Listed& scene : scenes) {
    nlohmann::ordered_json entry;
    entry["name"] = scene.name;
    entry["file"] = scene.file;
    entry["bodies"] = scene.bodies;
    entry["description"] = scene.description;
    list.push_back(std::move(entry));
  }
  return list.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

int list_scenes(bool json) {
  std::vector<Listed> scenes;
  int code = kExitDone;
  for (const std::filesystem::path& file : shipped_scenes()) {
    const Result<Scene> scene = read_scene(file);
    if (!scene) {
      print_error("poise scenes: {}\n", scene.error().message);
      code = kExitBadInput;
      continue;
    }
    const Scene& s = scene.value();
    const std::uint64_t bodies = s.bodies.size() + (s.tray ? 5 : 0) + generated_body_count(s);
    scenes.push_back({file.stem().string(), file.string(), bodies, s.description});
  }
  const Status written = io::write_stdout(json ? as_json(scenes) : as_table(scenes));
  if (!written) {
    print_error("poise scenes: {}\n", written.error().message);
    return kExitOutputFailed;
  }
  return code;
}

}  // namespace

void add_scenes_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("scenes", "List the scenes that ship");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "As JSON");
  command->footer("Example:\n  poise scenes");
  command->callback([json, &exit_code] { exit_code = list_scenes(*json); });
}

}  // namespace poise::app
