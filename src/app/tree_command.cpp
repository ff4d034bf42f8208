// SPDX-License-Identifier: MIT
#include "app/tree_command.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/exit_codes.h"
#include "app/option_values.h"
#include "build_info.h"
#include "io/atomic_file.h"
#include "io/run_document.h"
#include "poise/mesh.h"
#include "poise/sphere_tree.h"

namespace poise::app {
namespace {

struct TreeOptions {
  std::string mesh, output, json;
  std::optional<std::uint64_t> depth, threads, seed, samples;
  std::optional<double> scale;
  bool quiet = false;
};

/// What one call found, for the table and the JSON alike.
struct TreeReport {
  TreeOptions options;
  TreeBuildOptions build;
  std::size_t samples = 0;
  TriangleMesh mesh;
  MeshRepair repair;
  SphereTree tree;
  std::vector<TreeLevelFigures> levels;
  double diagonal_m = 0;
  double volume_m3 = 0;
  double build_ms = 0;
};

int refuse(int code, const std::string& message) {
  fmt::print(stderr, "poise tree: {}\n", message);
  return code;
}

std::string as_table(const TreeReport& report) {
  std::string text =
      fmt::format("{}: {} triangles, diagonal {:.6g} m, volume {:.6g} m^3\n", report.options.mesh, report.mesh.triangles.size(),
                  report.diagonal_m, report.volume_m3);
  if (report.repair.vertices_welded + report.repair.triangles_dropped > 0 || report.repair.flipped) {
    text += fmt::format("  {} vertices welded, {} triangles dropped{}\n", report.repair.vertices_welded,
                        report.repair.triangles_dropped, report.repair.flipped ? ", turned inside out" : "");
  }
  text += fmt::format("{} nodes in {:.0f} ms; {} samples a figure\n\n", report.tree.node_count(), report.build_ms, report.samples);
  text += fmt::format("{:>5} {:>8} {:>22} {:>22} {:>10} {:>10} {:>8}\n", "", "", "largest protrusion", "mean protrusion", "surface",
                      "inside", "volume");
  text += fmt::format("{:>5} {:>8} {:>12} {:>9} {:>12} {:>9} {:>10} {:>10} {:>8}\n", "level", "spheres", "m", "% diag", "m", "% diag",
                      "% covered", "% covered", "ratio");
  for (const TreeLevelFigures& f : report.levels) {
    text += fmt::format("{:>5} {:>8} {:>12.6g} {:>9.3f} {:>12.6g} {:>9.3f} {:>10.4f} {:>10.4f} {:>8.3f}\n", f.level, f.spheres,
                        f.protrusion_max_m, 100 * f.protrusion_max_m / report.diagonal_m, f.protrusion_mean_m,
                        100 * f.protrusion_mean_m / report.diagonal_m, 100 * f.surface_coverage, 100 * f.inside_coverage,
                        f.volume_ratio);
  }
  return text;
}

std::string as_json(const TreeReport& report) {
  nlohmann::ordered_json json;
  json["schema"] = "poise.tree/1";
  json["mesh"] = report.options.mesh;
  json["vertices"] = report.mesh.vertices_m.size();
  json["triangles"] = report.mesh.triangles.size();
  json["repair"] = {{"vertices_welded", report.repair.vertices_welded},
                    {"triangles_dropped", report.repair.triangles_dropped},
                    {"flipped", report.repair.flipped}};
  json["diagonal_m"] = report.diagonal_m;
  json["volume_m3"] = report.volume_m3;
  json["depth"] = report.build.depth;
  json["seed"] = report.build.seed;
  json["threads"] = report.build.threads;
  json["samples"] = report.samples;
  json["nodes"] = report.tree.node_count();
  json["build_ms"] = report.build_ms;
  json["levels"] = nlohmann::ordered_json::array();
  for (const TreeLevelFigures& f : report.levels) {
    json["levels"].push_back({{"level", f.level},
                              {"spheres", f.spheres},
                              {"protrusion_max_m", f.protrusion_max_m},
                              {"protrusion_mean_m", f.protrusion_mean_m},
                              {"protrusion_max_of_diagonal", f.protrusion_max_m / report.diagonal_m},
                              {"protrusion_mean_of_diagonal", f.protrusion_mean_m / report.diagonal_m},
                              {"surface_coverage", f.surface_coverage},
                              {"inside_coverage", f.inside_coverage},
                              {"volume_ratio", f.volume_ratio}});
  }
  const io::Machine machine = io::this_machine();
  json["machine"] = {{"system", machine.system}, {"processor", machine.processor}, {"cores", machine.cores}};
  json["build"] = {{"version", POISE_BUILD_VERSION},
                   {"commit", POISE_BUILD_COMMIT},
                   {"compiler", POISE_BUILD_COMPILER},
                   {"flags", POISE_BUILD_FLAGS}};
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

/// Reads, builds and judges; a refusal names the file.
Result<TreeReport> make_report(const TreeOptions& options) {
  TreeReport report;
  report.options = options;
  report.build.depth = static_cast<Level>(options.depth.value_or(report.build.depth));
  report.build.threads = static_cast<int>(options.threads.value_or(0));
  report.build.seed = options.seed.value_or(report.build.seed);
  report.samples = options.samples.value_or(20000);
  MeshReadOptions reading;
  reading.scale = options.scale.value_or(1.0);
  Result<TriangleMesh> mesh = read_mesh(options.mesh, reading, &report.repair);
  if (!mesh) return mesh.error();
  report.mesh = std::move(mesh).value();
  report.diagonal_m = report.mesh.diagonal_m();
  const auto in_file = [&](const Error& error) { return Error{error.kind, fmt::format("{}: {}", options.mesh, error.message)}; };
  const Result<MassProperties> mass = mesh_mass_properties(report.mesh);
  if (!mass) return in_file(mass.error());
  report.volume_m3 = mass.value().volume_m3;
  const auto start = std::chrono::steady_clock::now();
  Result<SphereTree> tree = build_sphere_tree(report.mesh, report.build);
  report.build_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (!tree) return in_file(tree.error());
  report.tree = std::move(tree).value();
  Result<std::vector<TreeLevelFigures>> levels = judge_tree(report.tree, report.mesh, {.samples = report.samples, .seed = report.build.seed, .threads = report.build.threads});
  if (!levels) return in_file(levels.error());
  report.levels = std::move(levels).value();
  return report;
}

Status write_report(const TreeOptions& options, const TreeReport& report) {
  if (!options.output.empty()) {
    Status written = write_sph(report.tree, options.output);
    if (!written) return written;
  }
  if (!options.json.empty()) {
    const std::string text = as_json(report);
    Status written = options.json == "-" ? io::write_stdout(text) : io::write_file(options.json, text);
    if (!written) return written;
  }
  // The standard output is one document: the JSON where it was asked for, else the table.
  if (options.quiet || options.json == "-") return Done{};
  return io::write_stdout(as_table(report));
}

int make_tree(const TreeOptions& options) {
  if (options.output == "-") return refuse(kExitBadUsage, "-o must name a file; only --json can go to the standard output");
  const Result<TreeReport> report = make_report(options);
  if (!report) return refuse(exit_code_of(report.error()), report.error().message);
  const Status written = write_report(options, report.value());
  return written ? kExitDone : refuse(exit_code_of(written.error()), written.error().message);
}

}  // namespace

void add_tree_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("tree", "Build the sphere tree of a closed mesh and judge it level by level");
  auto options = std::make_shared<TreeOptions>();
  command->add_option("mesh", options->mesh, "A closed mesh: OBJ, STL, PLY, OFF, glTF or GLB")->required()->type_name("MESH");
  add_whole(*command, "--depth", options->depth, 0, kMaxTreeDepth, "Levels below the root (default 3)");
  command->add_option("-o,--output", options->output, "Write the tree as .sph")->type_name("FILE");
  command->add_option("--json", options->json, "Write the figures as JSON (poise.tree/1), - for the standard output")->type_name("FILE");
  add_number(*command, "--scale", options->scale, 0, true, 1e9, "Metres per unit of the file (default 1)")->type_name("FACTOR");
  add_whole(*command, "--threads", options->threads, 0, 256, "Threads, 0 = as many as the machine has; the tree is the same (default 0)");
  add_whole(*command, "--seed", options->seed, 0, UINT64_MAX, "Of the search and of the judging samples (default 1)");
  add_whole(*command, "--samples", options->samples, 1, 100000000, "Samples for each figure (default 20000)");
  command->add_flag("--quiet", options->quiet, "No table");
  command->footer("Example:\n  poise tree bunny.obj --depth 3 -o bunny.sph --json bunny.json");
  command->callback([options, &exit_code] { exit_code = make_tree(*options); });
}

}  // namespace poise::app
