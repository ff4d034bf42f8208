// SPDX-License-Identifier: MIT
#include "app/scenes/import_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "assets/files/text_file.h"
#include "poise/types.h"
#include "scene/import/gltf_import.h"
#include "scene/import/mjcf_import.h"
#include "scene/import/scene_draft.h"

namespace poise::app {
namespace {

constexpr std::uint64_t kMostModelFileBytes = 64ULL << 20U;

struct ImportOptions {
  std::string file, output;
  bool skip_unmodelled = false;
  std::vector<std::string> fixed;
  bool all_fixed = false;
  bool floor = false;
  std::optional<double> dt_s, friction, scale, shell_thickness_m;
  std::optional<std::uint64_t> depth;
  bool quiet = false;
};

bool is_gltf(const ImportOptions& options) {
  const std::string ending = lower_case_ending(options.file);
  return ending == ".gltf" || ending == ".glb";
}

Status check_import_options(const ImportOptions& o) {
  const std::string ending = lower_case_ending(o.file);
  if (!is_gltf(o) && ending != ".xml" && ending != ".mjcf")
    return bad_input(fmt::format("{}: the ending must be .xml or .mjcf (MuJoCo), .gltf or .glb{}", o.file,
                                 ending == ".urdf" ? "; `poise tree` reads robots" : ""));
  if (lower_case_ending(o.output) != ".json")
    return bad_input(fmt::format("-o {}: the ending must be .json", o.output));
  const std::pair<const char*, bool> of_gltf[] = {{"--static", !o.fixed.empty()},
                                                  {"--all-static", o.all_fixed},
                                                  {"--floor", o.floor},
                                                  {"--friction", o.friction.has_value()},
                                                  {"--scale", o.scale.has_value()}};
  for (const auto& [name, given] : of_gltf)
    if (given && !is_gltf(o)) return bad_input(fmt::format("{} has no meaning but with glTF", name));
  if (o.skip_unmodelled && is_gltf(o)) return bad_input("--skip-unmodelled has no meaning with glTF");
  return check_outputs({{"-o", o.output}}, {{"FILE", o.file}});
}

Result<io::SceneDraft> read_model(const ImportOptions& options) {
  const std::filesystem::path folder = std::filesystem::path(options.file).parent_path();
  if (is_gltf(options)) {
    io::GltfImportSettings settings;
    settings.fixed = options.fixed;
    settings.all_fixed = options.all_fixed;
    settings.floor = options.floor;
    settings.friction = options.friction.value_or(settings.friction);
    settings.scale = options.scale.value_or(settings.scale);
    return io::import_gltf(options.file, settings);
  }
  const Result<std::string> text = geometry::read_text_file(options.file, kMostModelFileBytes);
  if (!text) return text.error();
  return io::import_mjcf(text.value(), options.file, folder, options.skip_unmodelled);
}

int import_scene(const ImportOptions& options) {
  const Status sound = check_import_options(options);
  if (!sound) return refuse("import", kExitBadUsage, sound.error().message);
  const Status writable = can_write({options.output});
  if (!writable) return refuse("import", writable.error());
  Result<io::SceneDraft> draft = read_model(options);
  if (!draft) return refuse("import", draft.error());
  io::SceneDraft& d = draft.value();
  d.dt_s = options.dt_s.value_or(d.dt_s);
  io::DraftSettings settings;
  settings.depth = options.depth.value_or(settings.depth);
  settings.shell_thickness_m = options.shell_thickness_m.value_or(settings.shell_thickness_m);
  const Result<io::WrittenDraft> written = io::write_draft(d, settings, options.output);
  if (!written) {
    const Error& error = written.error();
    return refuse("import", error.kind == ErrorKind::OutputFailed
                                ? error
                                : Error{error.kind, fmt::format("{}: {}", options.file, error.message)});
  }
  d.warnings.insert(d.warnings.end(), written.value().warnings.begin(), written.value().warnings.end());
  for (const std::string& warning : d.warnings) print_error("poise import: warning: {}\n", warning);
  if (options.quiet) return kExitDone;
  const auto moving = std::ranges::count_if(d.bodies, [](const io::DraftBody& body) { return body.dynamic; });
  const Status told =
      io::write_stdout(fmt::format("{}: {} bodies, {} of them dynamic, {} shapes, {} mesh files\n", options.output,
                                   d.bodies.size(), moving, written.value().shapes, written.value().mesh_files));
  return told ? kExitDone : refuse("import", told.error());
}

}  // namespace

void add_import_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("import", "Make a scene of a model of MuJoCo (MJCF) or of glTF nodes");
  auto options = std::make_shared<ImportOptions>();
  command->add_option("file", options->file, "The model: .xml or .mjcf (MuJoCo), .gltf or .glb")
      ->required()
      ->type_name("FILE");
  add_path(*command, "-o,--output", options->output,
           "The scene file to write; meshes that must be made go into a folder beside it")
      ->required();
  command->add_flag("--skip-unmodelled", options->skip_unmodelled,
                    "Of MuJoCo: leave out what is not modelled; bodies with other joints than free ones are fixed to "
                    "what they hang on");
  command->add_option("--static", options->fixed, "Of glTF: the node of this name does not move; may be repeated")
      ->type_name("NODE")
      ->expected(1);
  command->add_flag("--all-static", options->all_fixed, "Of glTF: no node moves");
  command->add_flag("--floor", options->floor, "Of glTF: a floor at the lowest point");
  add_number(*command, "--friction", options->friction, 0, false, 1e6, "Of glTF: of all bodies (default 0.5)")
      ->type_name("MU");
  add_number(*command, "--scale", options->scale, 1e-9, false, 1e9,
             "Of glTF: metres per unit of the file (default 1), such as 0.001 for millimetres")
      ->type_name("M");
  add_number(*command, "--dt", options->dt_s, 0, true, 1,
             "Time step in seconds (default that of the model, for glTF 1/60)")
      ->type_name("S");
  add_whole(*command, "--depth", options->depth, 0, kMaxTreeDepth, "Levels of sphere trees below the root (default 3)");
  add_number(*command, "--shell-thickness", options->shell_thickness_m, 1e-9, false, 1e9,
             "Of meshes that enclose no volume, metres (default 0.001)")
      ->type_name("M");
  command->add_flag("--quiet", options->quiet, "No line on the standard output");
  command->footer(
      "Examples:\n"
      "  poise import table.xml -o table.json && poise run table.json\n"
      "  poise import humanoid.xml -o humanoid.json --skip-unmodelled --dt 0.0166667\n"
      "  poise import room.glb -o room.json --static Floor --static Walls\n\n"
      "Exit codes: 0 done, 2 bad usage, 3 bad input or something that is not modelled, 4 output failed.");
  command->callback([options, &exit_code] { exit_code = import_scene(*options); });
}

}  // namespace poise::app
