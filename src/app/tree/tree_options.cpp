// SPDX-License-Identifier: MIT
#include "app/tree/tree_options.h"

#include <fmt/format.h>

#include <utility>

#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "app/options/suggestions.h"

namespace poise::app {
namespace {

/// An option by its name, and whether it was given.
using Given = std::pair<const char*, bool>;

Status refuse_given(std::initializer_list<Given> options, const std::string& why) {
  for (const auto& [name, given] : options) {
    if (given) return bad_input(fmt::format("{} {}", name, why));
  }
  return Done{};
}

/// Level files hold one level; which one must be known.
bool writes_a_level(const TreeOptions& o) {
  const std::optional<TreeFormat> format = tree_format_of(o.output);
  return format && *format != TreeFormat::Sph;
}

Status check_output(const TreeOptions& o) {
  if (o.output == "-") return bad_input("-o must name a file; only --json can go to the standard output");
  for (const auto& [option, file] :
       {std::pair("--picture", &o.picture), std::pair("--picture-dark", &o.picture_dark)}) {
    if (*file == "-")
      return bad_input(fmt::format("{} must name a file; only --json can go to the standard output", option));
    const Status picture = check_picture(*file, option);
    if (!picture) return picture;
  }
  if (!o.output.empty() && !tree_format_of(o.output)) {
    return bad_input(fmt::format("-o {}: the ending must be .sph, .urdf, .yml, .yaml or .json", o.output));
  }
  if (o.level && !writes_a_level(o)) return bad_input("--level needs -o with a .urdf, .yml, .yaml or .json file");
  for (const std::string& mesh : o.meshes) {
    const Status apart = check_outputs(
        {{"-o", o.output}, {"--json", o.json}, {"--picture", o.picture}, {"--picture-dark", o.picture_dark}},
        {{"MESH", mesh}, {"--tree", o.tree}, {"--compare", o.compare}});
    if (!apart) return apart;
  }
  return check_outputs({{"-o", o.output}}, {{"--tree", o.tree}});
}

Status check_report(const TreeOptions& o) {
  if (o.meshes.empty()) return bad_input("--inspect needs a MESH");
  return refuse_given({{"--tree", !o.tree.empty()},
                       {"--compare", !o.compare.empty()},
                       {"-o", !o.output.empty()},
                       {"--picture", !o.picture.empty()},
                       {"--picture-dark", !o.picture_dark.empty()},
                       {"--up", o.up.has_value()},
                       {"--front", o.front.has_value()},
                       {"--depth", o.depth.has_value()},
                       {"--preset", o.preset.has_value()},
                       {"--seed", o.seed.has_value()},
                       {"--samples", o.samples.has_value()},
                       {"--threads", o.threads.has_value()},
                       {"--level", o.level.has_value()},
                       {"--shell", o.shell},
                       {"--package", !o.packages.empty()},
                       {"--require-coverage", o.require_coverage}},
                      "has no meaning with --inspect, which builds no tree");
}

Status check_convert(const TreeOptions& o) {
  if (o.tree.empty()) return bad_input("a MESH to build a tree of, or --tree FILE to convert, is required");
  if (o.output.empty()) return bad_input("--tree without a MESH converts, and needs -o FILE");
  return refuse_given({{"--compare", !o.compare.empty()},
                       {"--json", !o.json.empty()},
                       {"--picture", !o.picture.empty()},
                       {"--picture-dark", !o.picture_dark.empty()},
                       {"--up", o.up.has_value()},
                       {"--front", o.front.has_value()},
                       {"--depth", o.depth.has_value()},
                       {"--preset", o.preset.has_value()},
                       {"--seed", o.seed.has_value()},
                       {"--samples", o.samples.has_value()},
                       {"--threads", o.threads.has_value()},
                       {"--scale", o.scale.has_value()},
                       {"--shell", o.shell},
                       {"--require-coverage", o.require_coverage}},
                      "needs a MESH; --tree alone only converts");
}

Status check_robot(const TreeOptions& o) {
  if (o.meshes.size() > 1) return bad_input("one robot at a time; only --inspect takes more than one file");
  for (const std::string& package : o.packages) {
    const std::size_t sign = package.find('=');
    if (sign == 0 || sign == std::string::npos || sign + 1 == package.size())
      return bad_input(fmt::format("--package = '{}', must be NAME=FOLDER", package));
  }
  if (!o.output.empty() && tree_format_of(o.output) != TreeFormat::Urdf)
    return bad_input(fmt::format("-o {}: of a robot a .urdf is written", o.output));
  if (o.level && *o.level > o.depth.value_or(TreeBuildOptions{}.depth))
    return bad_input(
        fmt::format("--level {} is below --depth {}", *o.level, o.depth.value_or(TreeBuildOptions{}.depth)));
  return refuse_given({{"--tree", !o.tree.empty()},
                       {"--compare", !o.compare.empty()},
                       {"--picture", !o.picture.empty()},
                       {"--picture-dark", !o.picture_dark.empty()},
                       {"--up", o.up.has_value()},
                       {"--front", o.front.has_value()},
                       {"--scale", o.scale.has_value()}},
                      "has no meaning with a robot");
}

}  // namespace

void add_tree_options(CLI::App& command, TreeOptions& o) {
  command.add_option("mesh", o.meshes, "OBJ, STL, PLY, OFF, glTF or GLB, several with --inspect; or a robot: URDF")
      ->type_name("MESH");
  add_path(command, "--tree", o.tree, "Measure this tree instead of building one; without a MESH, convert it to -o");
  add_path(command, "--compare", o.compare,
           "Measure this tree too and set both side by side; the better figure is marked *");
  add_whole(command, "--depth", o.depth, 0, kMaxTreeDepth, "Levels below the root (default 3)");
  command.add_option("--preset", o.preset, "How much time the tree is worth: fast, default or best")
      ->check(one_of({"fast", "default", "best"}))
      ->type_name("NAME");
  command.add_flag("--shell", o.shell, "The object is the surface alone, not what it encloses");
  add_path(command, "-o,--output", o.output,
           "Write the tree as .sph, or a level of it as .urdf, .yml (cuRobo) or .json (foam)");
  command
      .add_option("--package", o.packages,
                  "Of a robot: where package://NAME/ is (default: the first such folder beside or above the file); may "
                  "be repeated")
      ->type_name("NAME=FOLDER")
      ->expected(1);
  add_whole(command, "--level", o.level, 0, kMaxTreeDepth,
            "The level to write as .urdf, .yml or .json (default the deepest)");
  add_path(command, "--json", o.json, "Write the figures as JSON (poise.tree/2), - for the standard output");
  add_path(command, "--picture", o.picture,
           "Draw the mesh and every level beside it as PNG, coloured by how far the balls stand out");
  add_path(command, "--picture-dark", o.picture_dark, "The same on a dark ground");
  command
      .add_option("--up", o.up,
                  "The axis that is upward in the picture: x, y, z, -x, -y or -z (default z, but y for glTF)")
      ->check(one_of({"x", "y", "z", "-x", "-y", "-z"}))
      ->option_text("AXIS");
  command
      .add_option("--front", o.front,
                  "Towards where the mesh looks: the picture is from there, turned and from above (default -y, but z "
                  "with --up y)")
      ->check(one_of({"x", "y", "z", "-x", "-y", "-z"}))
      ->option_text("AXIS");
  add_whole(command, "--samples", o.samples, 1, 100000000, "Samples for each figure (default 20000)");
  add_whole(command, "--seed", o.seed, 0, UINT64_MAX, "Of the search and of the samples (default 1)");
  add_whole(command, "--threads", o.threads, 0, 256,
            "Threads, 0 = as many as the machine has; the tree is the same (default 0)");
  add_number(command, "--scale", o.scale, 0, true, 1e9, "Metres per unit of the mesh file (default 1)")
      ->type_name("FACTOR");
  command.add_flag("--require-coverage", o.require_coverage,
                   "Exit with 1 if a tree leaks: some sampled point is not covered");
  command.add_flag("--inspect", o.report,
                   "Only say what each MESH is: closed, open or a sheet, and what follows from that");
  command.add_flag("--quiet", o.quiet, "No table and no progress");
  command.footer(
      "Examples:\n"
      "  poise tree bunny.obj -o bunny.sph --picture bunny.png --up y     build, measure, write, draw\n"
      "  poise tree bunny.obj --depth 2 --preset best --seed 7 --json -   figures for a program\n"
      "  poise tree bunny.obj --tree other.sph --require-coverage         measure a foreign tree\n"
      "  poise tree bunny.obj --compare other.sph --samples 1000000       ours beside another\n"
      "  poise tree --tree bunny.sph -o bunny.urdf --level 2              convert, without the mesh\n"
      "  poise tree robot.urdf -o spheres.urdf --level 2                  all links of a robot at once\n"
      "  poise tree --inspect models/*.stl                                what are these meshes?\n"
      "  poise tree sheet.ply --shell --scale 0.001                       a surface in millimetres\n\n"
      "A tree is always built anew here, never taken from the cache, since its cost is part of the answer.\n"
      "Exit codes: 0 done, 1 --require-coverage does not hold, 2 bad usage, 3 bad input, 4 output failed, 130 stopped "
      "by\n"
      "Ctrl-C, 143 by SIGTERM, with nothing written.");
}

bool draws(const TreeOptions& o) { return !o.picture.empty() || !o.picture_dark.empty(); }

TreeTask task_of(const TreeOptions& options) {
  if (options.report) return TreeTask::Inspect;
  if (!options.meshes.empty() && lower_case_ending(options.meshes.front()) == ".urdf") return TreeTask::Robot;
  return options.meshes.empty() ? TreeTask::Convert : TreeTask::Measure;
}

Status check_tree_options(const TreeOptions& o) {
  Status sound = check_output(o);
  if (!sound) return sound;
  if (task_of(o) == TreeTask::Inspect) return check_report(o);
  if (task_of(o) == TreeTask::Robot) return check_robot(o);
  if (!o.packages.empty()) return bad_input("--package has no meaning but with a robot (.urdf)");
  if (task_of(o) == TreeTask::Convert) return check_convert(o);
  if (o.meshes.size() > 1)
    return bad_input(fmt::format("{} meshes are named; only --inspect takes more than one", o.meshes.size()));
  if (o.up && !draws(o)) return bad_input("--up needs --picture");
  if (o.front && !draws(o)) return bad_input("--front needs --picture");
  if (o.front && axis_of(*o.front).dot(axis_of(up_of(o))) != 0) {
    return bad_input(fmt::format("--front {} and --up {} must be different axes", *o.front, up_of(o)));
  }
  const std::uint64_t depth = o.depth.value_or(TreeBuildOptions{}.depth);
  if (o.tree.empty() && o.level.value_or(0) > depth)
    return bad_input(fmt::format("--level {} is below --depth {}", *o.level, depth));
  if (o.tree.empty()) return Done{};
  if (!o.output.empty() && !o.compare.empty())
    return bad_input("-o has no meaning with --compare and --tree: which of the two trees is meant?");
  return refuse_given({{"--depth", o.depth.has_value()}, {"--preset", o.preset.has_value()}},
                      "has no meaning with --tree, which is not built");
}

std::string up_of(const TreeOptions& options) {
  if (options.up) return *options.up;
  const std::string ending = options.meshes.empty() ? "" : lower_case_ending(options.meshes.front());
  return ending == ".gltf" || ending == ".glb" ? "y" : "z";
}

Vec3 axis_of(const std::string& name) {
  const Vec3 axis = name.ends_with('x') ? Vec3::UnitX() : name.ends_with('y') ? Vec3::UnitY() : Vec3::UnitZ();
  return name.starts_with('-') ? Vec3(-axis) : axis;
}

TreePreset preset_of(const std::string& name) {
  return name == "fast" ? TreePreset::Fast : name == "best" ? TreePreset::Best : TreePreset::Default;
}

}  // namespace poise::app
