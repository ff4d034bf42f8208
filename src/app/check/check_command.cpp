// SPDX-License-Identifier: MIT
#include "app/check/check_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "app/files/output_files.h"
#include "app/files/scene_input.h"
#include "app/options/option_values.h"
#include "app/options/tree_cache_options.h"
#include "app/process/exit_codes.h"
#include "app/process/process_memory.h"
#include "app/process/refusal.h"
#include "scene/check/scene_check.h"
#include "sweep/trial.h"

namespace poise::app {
namespace {

struct CheckOptions {
  std::string scene, json;
  std::optional<std::uint64_t> bodies, seed, threads, max_memory_mib;
  TreeCacheOptions tree_cache;
  bool strict = false;
  bool quiet = false;
};

constexpr double kMebibyte = 1024.0 * 1024.0;

std::string table(const std::string& name, const io::SceneCheck& c) {
  std::string text = fmt::format("{}: sound, {} bodies, {} of them moving\n", name, c.bodies, c.dynamic_bodies);
  text += fmt::format("memory      about {:.0f} MiB on {} threads\n", c.memory_bytes / kMebibyte, c.threads);
  text += c.trees_to_build > 0 ? fmt::format("trees       {} to build, about {:.0f} s; {} ready\n", c.trees_to_build,
                                             c.tree_wall_s, c.trees_ready)
                               : fmt::format("trees       none to build; {} ready\n", c.trees_ready);
  text += fmt::format(
      "deadline    {:.3g} ms; all bodies in a heap would take about {:.2g} ms before refinement, one pair "
      "of shapes up to {:.2g} ms of it\n",
      c.deadline_ms, c.heap_frame_ms, c.pair_ms);
  for (const std::string& warning : c.warnings) text += "warning     " + warning + "\n";
  return text;
}

// What tells a scene from others; empty where it could not be read.
struct SceneFacts {
  std::optional<std::size_t> generators;
  std::optional<std::string> hash;
};

SceneFacts facts_of(const SceneText& text, const Scene& scene) {
  const Result<std::string> hash = sweep::scene_hash(text.text, scene);
  return {scene.generators.size(), hash ? std::optional(hash.value()) : std::nullopt};
}

std::string json_of(const std::string& name, const SceneFacts& facts, const io::SceneCheck& c) {
  using Json = nlohmann::ordered_json;
  Json needs = nullptr;
  if (c.errors.empty()) {
    needs = {{"bodies", c.bodies},           {"dynamic_bodies", c.dynamic_bodies},
             {"threads", c.threads},         {"memory_bytes", static_cast<std::uint64_t>(c.memory_bytes)},
             {"trees_ready", c.trees_ready}, {"trees_to_build", c.trees_to_build},
             {"tree_cpu_s", c.tree_cpu_s},   {"tree_wall_s", c.tree_wall_s},
             {"deadline_ms", c.deadline_ms}, {"heap_frame_ms", c.heap_frame_ms},
             {"pair_ms", c.pair_ms}};
  }
  const Json json = {{"schema", "poise.check/1"},
                     {"scene", name},
                     {"scene_hash", facts.hash ? Json(*facts.hash) : Json(nullptr)},
                     {"generators", facts.generators ? Json(*facts.generators) : Json(nullptr)},
                     {"sound", c.errors.empty()},
                     {"errors", c.errors},
                     {"warnings", c.warnings},
                     {"needs", needs}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

int tell(const CheckOptions& options, const std::string& name, const SceneFacts& facts, const io::SceneCheck& check) {
  for (const std::string& error : check.errors) refuse("check", kExitBadInput, error);
  Status written = options.json.empty() ? Status(Done{}) : write_to(options.json, json_of(name, facts, check));
  if (written && !options.quiet && options.json != "-" && check.errors.empty())
    written = write_to("-", table(name, check));
  if (!written) return refuse("check", written.error());
  if (!check.errors.empty()) return kExitBadInput;
  return options.strict && !check.warnings.empty() ? kExitRequirementFailed : kExitDone;
}

int check_command(const CheckOptions& options) {
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.tree_cache);
  if (!cache) return refuse("check", kExitBadUsage, cache.error().message);
  const Status apart = check_outputs({{"--json", options.json}}, {{"SCENE", options.scene}});
  if (!apart) return refuse("check", kExitBadUsage, apart.error().message);
  const Result<SceneText> text = read_scene_argument(options.scene, "check", options.quiet);
  io::SceneCheck check;
  if (!text) {
    check.errors.push_back(text.error().message);
    return tell(options, options.scene, {}, check);
  }
  const Result<Scene> scene = parse_scene_text(text.value(), check.errors);
  if (!scene) return tell(options, text.value().name, {}, check);
  const Status keeps = check_scene_files({{"--json", options.json}}, scene.value());
  if (!keeps) return refuse("check", kExitBadUsage, keeps.error().message);
  io::SceneCheckOptions asked;
  asked.bodies = options.bodies;
  asked.seed = options.seed;
  asked.max_memory_bytes = max_memory_bytes(options.max_memory_mib);
  asked.threads = static_cast<int>(options.threads.value_or(0));
  asked.tree_cache = cache.value();
  const SceneFacts facts = options.json.empty() ? SceneFacts{} : facts_of(text.value(), scene.value());
  return tell(options, scene.value().name, facts, io::check_scene(scene.value(), asked));
}

}  // namespace

void add_check_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand("check", "Say what is wrong with a scene, what it needs and what looks wrong");
  add_scene(*command, options->scene);
  add_whole(*command, "--bodies", options->bodies, 1, kMaxSceneBodies, "As for poise run");
  add_whole(*command, "--seed", options->seed, 0, UINT64_MAX, "As for poise run");
  add_whole(*command, "--threads", options->threads, 0, 256, "As for poise run");
  add_path(*command, "--json", options->json, "Write the result as JSON (poise.check/1), - for the standard output");
  add_tree_cache_options(*command, options->tree_cache);
  add_max_memory(*command, options->max_memory_mib);
  command->add_flag("--strict", options->strict, "Exit with 1 where there are warnings");
  command->add_flag("--quiet", options->quiet, "Only the errors");
  command->footer(
      "Examples:\n"
      "  poise check my-scene.json\n"
      "  poise check pile --bodies 50000 --strict\n"
      "  generate-scene | poise check - --json -\n\n"
      "No tree is built and no frame is made; what it needs is estimated (docs/scene-format.md).\n"
      "Exit codes: 0 sound, 1 --strict and there are warnings, 2 bad usage, 3 the scene cannot run, 4 output failed.");
  command->callback([options, &exit_code] { exit_code = check_command(*options); });
}

}  // namespace poise::app
