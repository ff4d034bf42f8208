// SPDX-License-Identifier: MIT
#include "studies/study_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "geometry/mesh/procedural.h"

namespace poise::app {
namespace {

constexpr const char* kDefaultPairs =
    "jack,jack;torus,torus;bowl,bowl;jack,torus;torus,bowl;jack,bowl;slab,slab;l,l;cube,cube;disc,disc;cube,jack;slab,"
    "torus;l,bowl;"
    "disc,jack";
constexpr const char* kDefaultLevels = "0,1,2,3,4,polygons";
// From libsimbody-dev: two closed parts of a robot's arm, one more round and one more flat.
constexpr const char* kOthers[2] = {"/usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry/Base.obj",
                                    "/usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry/Wrist3.obj"};

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == at) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

bool is_file(const std::string& name) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(name, ignored);
}

Status add_pairs(const std::string& text, LevelsPlan& plan) {
  const auto known = geometry::procedural_shapes();
  for (const std::string& pair : split(text, ';')) {
    const std::vector<std::string> names = split(pair, ',');
    if (names.size() != 2)
      return bad_input(fmt::format("--pairs: \"{}\", must be two names with a comma between them", pair));
    for (const std::string& name : names) {
      if (std::ranges::find(known, std::string_view(name)) == known.end() && !is_file(name)) {
        return bad_input(fmt::format("--pairs: \"{}\" is no file and none of {}", name, fmt::join(known, ", ")));
      }
    }
    plan.pairs.emplace_back(names[0], names[1]);
  }
  return Done{};
}

// Pairs each mesh with itself and with the next one.
void add_meshes(const std::vector<std::string>& files, LevelsPlan& plan) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    plan.pairs.emplace_back(files[i], files[i]);
    if (i + 1 < files.size()) plan.pairs.emplace_back(files[i], files[i + 1]);
  }
}

Status add_models(const std::string& text, LevelsPlan& plan) {
  std::vector<std::string_view> names;
  for (const simulation::NamedContactModel& model : simulation::kContactModels) names.push_back(model.name);
  if (text.empty()) {
    plan.models.assign(simulation::kContactModels.begin(), simulation::kContactModels.end());
    return Done{};
  }
  for (const std::string& word : split(text, ',')) {
    const auto at =
        std::ranges::find(simulation::kContactModels, std::string_view(word), &simulation::NamedContactModel::name);
    if (at == simulation::kContactModels.end()) {
      return bad_input(fmt::format("--models: \"{}\", must be of {}", word, fmt::join(names, ", ")));
    }
    if (std::ranges::find(plan.models, at->name, &simulation::NamedContactModel::name) != plan.models.end()) {
      return bad_input(fmt::format("--models: {} is named twice", word));
    }
    plan.models.push_back(*at);
  }
  return Done{};
}

Status add_levels(const std::string& text, std::uint64_t depth, LevelsPlan& plan) {
  for (const std::string& word : split(text.empty() ? kDefaultLevels : text, ',')) {
    if (!plan.levels.empty() && plan.levels.back().polygons) return bad_input("--levels: nothing comes after polygons");
    if (word == "polygons") {
      plan.levels.push_back({kMaxTreeDepth, true});
      continue;
    }
    const bool digit = word.size() == 1 && word[0] >= '0' && word[0] <= '9';
    if (!digit || static_cast<std::uint64_t>(word[0] - '0') > depth) {
      if (text.empty()) continue;  // the default levels are those of the trees
      return bad_input(
          fmt::format("--levels: \"{}\", must be polygons or from 0 to {}, the depth of the trees", word, depth));
    }
    const simulation::ProbeLevel level{static_cast<Level>(word[0] - '0'), false};
    if (!plan.levels.empty() && level.level <= plan.levels.back().level) return bad_input("--levels: must ascend");
    plan.levels.push_back(level);
  }
  return Done{};
}

}  // namespace

Result<LevelsPlan> plan_of(const StudyLevelsOptions& options) {
  LevelsPlan plan;
  if (!options.pairs.empty() && !options.meshes.empty())
    return bad_input("MESH has no meaning with --pairs, which may name files");
  Status done =
      options.meshes.empty() ? add_pairs(options.pairs.empty() ? kDefaultPairs : options.pairs, plan) : Status(Done{});
  if (!done) return done.error();
  add_meshes(options.meshes, plan);
  if (options.pairs.empty() && options.meshes.empty()) {
    std::vector<std::string> others;
    for (const char* file : kOthers) {
      if (is_file(file)) {
        others.emplace_back(file);
      } else {
        plan.missing.push_back(fmt::format("libsimbody-dev, {}", std::filesystem::path(file).filename().string()));
      }
    }
    add_meshes(others, plan);
  }
  done = add_models(options.models, plan);
  if (done) done = add_levels(options.levels, options.depth.value_or(4), plan);
  if (!done) return done.error();
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.tree_cache);
  if (!cache) return cache.error();
  if (std::ranges::count(std::vector{options.json, options.markdown, options.csv}, "-") > 1) {
    return bad_input("only one of --json, --markdown and --csv can go to the standard output");
  }
  const Status picture = check_plot_files(options.picture);
  if (!picture) return picture.error();
  for (const std::string& mesh : options.meshes.empty() ? std::vector<std::string>{""} : options.meshes) {
    const Status apart = check_outputs({{"--json", options.json},
                                        {"--markdown", options.markdown},
                                        {"--csv", options.csv},
                                        {"--picture", options.picture.png},
                                        {"--picture-dark", options.picture.png_dark},
                                        {"--svg", options.picture.svg}},
                                       {{"MESH", mesh}});
    if (!apart) return apart.error();
  }
  return plan;
}

void add_study_levels_options(CLI::App& command, StudyLevelsOptions& o) {
  command
      .add_option("mesh", o.meshes,
                  "Closed meshes instead of the shapes of the docs: each with itself and with the next")
      ->type_name("MESH");
  command.add_option("--pairs", o.pairs, "Pairs of shapes instead, as A,B;C,D: names as of poise shape, or files")
      ->type_name("LIST");
  command.add_option("--models", o.models, "Contact models, with commas between them (default all)")->type_name("LIST");
  command.add_option("--levels", o.levels, "Levels, ascending, with commas between them (default 0,1,2,3,4,polygons)")
      ->type_name("LIST");
  add_whole(command, "--touches", o.touches, 1, 100000, "Touches a pair of shapes (default 100)");
  command
      .add_option("--half", o.half,
                  "Touches for choosing parameters, for reporting on them, or all: tune, report, all (default report)")
      ->check(CLI::IsMember({"tune", "report", "all"}))
      ->type_name("HALF");
  add_whole(command, "--seed", o.seed, 0, UINT64_MAX, "Of the throws (default 1)");
  add_whole(command, "--depth", o.depth, 0, kMaxTreeDepth, "Levels of the trees below the root (default 4)");
  add_whole(command, "--fineness", o.fineness, 1, geometry::kMaxFineness,
            "How many times more edges the round parts of named shapes have (default 8)");
  add_whole(command, "--threads", o.threads, 0, 256,
            "Threads, 0 = as many as the machine has (default 0); costs are measured on one");
  add_path(command, "--json", o.json, "Write the rows as JSON (poise.levels/2), - for the standard output");
  add_path(command, "--csv", o.csv, "Write a line a row, - for the standard output");
  add_path(command, "--markdown", o.markdown, "Write the tables for docs, - for the standard output");
  add_plot_files(command, o.picture, "Draw error against level as a PNG (needs gnuplot)");
  add_path(command, "--svg", o.picture.svg, "The same as an SVG, light or dark as the browser prefers");
  add_tree_cache_options(command, o.tree_cache);
  command.add_flag("--quiet", o.quiet, "No tables and no progress");
  command.footer(
      "Examples:\n"
      "  poise study levels --markdown levels.md --picture levels.png      what docs/method.md shows\n"
      "  poise study levels --pairs 'l,bowl;cube,cube' --touches 1000 --models wrench\n"
      "  poise study levels gear.stl lever.stl --csv -\n\n"
      "Two bodies are thrown at each other at 2 m/s until they touch, exactly (libfcl); the answer of each level in "
      "that very place is\n"
      "compared with the exact one, a single impulse along the true normal. Meshes by others are scaled to a size of 1 "
      "m. Errors\n"
      "do not depend on threads; nanoseconds do on the machine.");
}

}  // namespace poise::app
