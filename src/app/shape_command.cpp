// SPDX-License-Identifier: MIT
#include "app/shape_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>

#include "app/exit_codes.h"
#include "geometry/procedural.h"
#include "io/atomic_file.h"

namespace poise::app {
namespace {

struct ShapeOptions {
  std::string kind;
  int fineness = 1;
  std::string output;
};

int refuse(int code, const std::string& message) {
  fmt::print(stderr, "poise shape: {}\n", message);
  return code;
}

int make_shape(const ShapeOptions& options) {
  const Result<TriangleMesh> mesh = geometry::make_procedural_shape(options.kind, options.fineness);
  if (!mesh) return refuse(kExitBadUsage, mesh.error().message);
  const std::string text = geometry::obj_text(mesh.value(), fmt::format("made by: poise shape {}{}", options.kind, options.fineness == 1 ? "" : fmt::format(" --fineness {}", options.fineness)));
  const Status written = options.output == "-" ? io::write_stdout(text) : io::write_file(options.output, text);
  return written ? kExitDone : refuse(exit_code_of(written.error()), written.error().message);
}

}  // namespace

void add_shape_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("shape", "Make a small closed mesh, about 1 m across");
  auto options = std::make_shared<ShapeOptions>();
  command->add_option("kind", options->kind, fmt::format("One of {}", fmt::join(geometry::procedural_shapes(), ", ")))
      ->required()
      ->type_name("KIND");
  command->add_option("-o,--output", options->output, "OBJ file to write, - for the standard output")->required()->type_name("FILE");
  command->add_option("--fineness", options->fineness, "How many times more edges round parts have")
      ->check(CLI::Range(1, geometry::kMaxFineness))
      ->capture_default_str();
  command->footer("Example:\n  poise shape jack -o jack.obj");
  command->callback([options, &exit_code] { exit_code = make_shape(*options); });
}

}  // namespace poise::app
