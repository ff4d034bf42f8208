// SPDX-License-Identifier: MIT
#include "app/files/scene_input.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>
#include <utility>

#include "app/files/scene_files.h"
#include "app/process/standard_streams.h"
#include "scene/scene_parse.h"
#include "scene/scene_shapes.h"

namespace poise::app {
namespace {

/// So long may the standard input be silent before a person is told what is waited for. Chosen.
constexpr int kSilentMs = 1000;

}  // namespace

Result<SceneText> read_scene_argument(const std::string& scene, std::string_view command, bool quiet) {
  if (scene == "-") {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (!quiet && ::poll(&input, 1, ::isatty(STDIN_FILENO) == 1 ? 0 : kSilentMs) == 0)
      print_error("poise {}: waiting for a scene on the standard input\n", command);
    Result<std::string> text = io::read_scene_stream(std::cin, "standard input");
    if (!text) return text.error();
    return SceneText{std::move(text).value(), "standard input", "."};
  }
  const Result<std::filesystem::path> file = find_scene(scene);
  if (!file) return file.error();
  Result<std::string> text = io::read_scene_text(file.value());
  if (!text) return text.error();
  return SceneText{std::move(text).value(), file.value().string(), file.value().parent_path()};
}

Result<Scene> parse_scene_text(const SceneText& scene, std::vector<std::string>& errors) {
  return parse_scene(scene.text, scene.name, scene.base, &errors);
}

Status check_scene_files(std::initializer_list<NamedFile> outputs, const Scene& scene) {
  for (const std::filesystem::path& file : io::files_of(scene)) {
    const Status apart = check_outputs(outputs, {{"a file of the scene", file.string()}});
    if (!apart) return apart;
  }
  return Done{};
}

}  // namespace poise::app
