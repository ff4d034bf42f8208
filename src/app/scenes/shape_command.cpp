// SPDX-License-Identifier: MIT
#include "app/scenes/shape_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "geometry/mesh/procedural.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

struct ShapeOptions {
  std::string kind;
  int fineness = 1;
  std::vector<double> size_m;
  std::optional<double> inner_m, outer_m, angle_deg, depth_m;
  std::string output;
};

struct Made {
  TriangleMesh mesh;
  std::string options;  // that make it again
};

Result<Made> make_wedge_of(const ShapeOptions& o) {
  if (!o.inner_m || !o.outer_m || !o.angle_deg || !o.depth_m)
    return bad_input("wedge needs --inner, --outer, --angle and --depth");
  Result<TriangleMesh> mesh = geometry::make_wedge({*o.inner_m, *o.outer_m, *o.angle_deg, *o.depth_m});
  if (!mesh) return mesh.error();
  return Made{std::move(mesh).value(), fmt::format(" --inner {} --outer {} --angle {} --depth {}", *o.inner_m,
                                                   *o.outer_m, *o.angle_deg, *o.depth_m)};
}

Result<Made> make_box_of(const ShapeOptions& o) {
  if (o.size_m.size() != 3) return bad_input("box needs --size X,Y,Z");
  Result<TriangleMesh> mesh = geometry::make_box({o.size_m[0], o.size_m[1], o.size_m[2]});
  if (!mesh) return mesh.error();
  return Made{std::move(mesh).value(), fmt::format(" --size {}", fmt::join(o.size_m, ","))};
}

Result<Made> make(const ShapeOptions& o) {
  if (o.kind != "box" && !o.size_m.empty()) return bad_input("--size has no meaning but with box");
  if (o.kind != "wedge" && (o.inner_m || o.outer_m || o.angle_deg || o.depth_m)) {
    return bad_input("--inner, --outer, --angle and --depth have no meaning but with wedge");
  }
  if ((o.kind == "box" || o.kind == "wedge") && o.fineness != 1)
    return bad_input("--fineness has no meaning with box and wedge");
  if (o.kind == "box") return make_box_of(o);
  if (o.kind == "wedge") return make_wedge_of(o);
  Result<TriangleMesh> mesh = geometry::make_procedural_shape(o.kind, o.fineness);
  if (!mesh) return mesh.error();
  return Made{std::move(mesh).value(), o.fineness == 1 ? "" : fmt::format(" --fineness {}", o.fineness)};
}

int make_shape(const ShapeOptions& options) {
  const Result<Made> made = make(options);
  if (!made) return refuse("shape", kExitBadUsage, made.error().message);
  const std::string text = geometry::obj_text(
      made.value().mesh, fmt::format("made by: poise shape {}{}", options.kind, made.value().options));
  const Status written = options.output == "-" ? io::write_stdout(text) : io::write_file(options.output, text);
  return written ? kExitDone : refuse("shape", exit_code_of(written.error()), written.error().message);
}

}  // namespace

void add_shape_command(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("shape", "Make a small closed mesh, about 1 m across, or a box or wedge of any size");
  auto options = std::make_shared<ShapeOptions>();
  command
      ->add_option("kind", options->kind,
                   fmt::format("One of {}, box, wedge", fmt::join(geometry::procedural_shapes(), ", ")))
      ->required()
      ->type_name("KIND");
  command->add_option("-o,--output", options->output, "OBJ file to write, - for the standard output")
      ->required()
      ->type_name("FILE");
  command->add_option("--fineness", options->fineness, "How many times more edges round parts have")
      ->check(CLI::Range(1, geometry::kMaxFineness))
      ->capture_default_str();
  command->add_option("--size", options->size_m, "Of a box: its edges along x, y and z in metres")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command->add_option("--inner", options->inner_m, "Of a wedge: radius of the arch inside, m")->type_name("M");
  command->add_option("--outer", options->outer_m, "Of a wedge: radius of the arch outside, m")->type_name("M");
  command->add_option("--angle", options->angle_deg, "Of a wedge: its share of the arch, degrees")->type_name("DEG");
  command->add_option("--depth", options->depth_m, "Of a wedge: how deep the arch is, along y, m")->type_name("M");
  command->footer(
      "Examples:\n"
      "  poise shape jack -o jack.obj\n"
      "  poise shape box --size 0.4,0.2,0.2 -o brick.obj\n"
      "  poise shape wedge --inner 0.875 --outer 1.125 --angle 16.363636363636363 --depth 0.4 -o stone.obj\n\n"
      "A box lies around the origin. A wedge is the keystone of an arch around the y axis; turned about it, it is any "
      "other stone.");
  command->callback([options, &exit_code] { exit_code = make_shape(*options); });
}

}  // namespace poise::app
