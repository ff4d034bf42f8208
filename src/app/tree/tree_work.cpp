// SPDX-License-Identifier: MIT
#include "app/tree/tree_work.h"

#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <stop_token>
#include <utility>

#include "app/process/process_memory.h"
#include "app/process/refusal.h"
#include "poise/assets/mesh_file.h"
#include "poise/assets/sph_file.h"
#include "poise/assets/tree_formats.h"

namespace poise::app {
namespace {

double process_cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

Error in_file(const std::string& file, const Error& error) {
  return {error.kind, fmt::format("{}: {}", file, error.message)};
}

TreeBuildOptions build_options(const TreeOptions& options, Solidity solidity) {
  TreeBuildOptions build;
  build.depth = static_cast<Level>(options.depth.value_or(build.depth));
  build.preset = preset_of(options.preset.value_or("default"));
  build.solidity = solidity;
  build.seed = options.seed.value_or(build.seed);
  build.threads = static_cast<int>(options.threads.value_or(0));
  return build;
}

/// What is known of a mesh before it has a tree.
Status describe(TriangleMesh mesh, const TreeOptions& options, TreeWork& work) {
  io::TreeDocument& d = work.document;
  work.mesh = std::move(mesh);
  d.vertices = work.mesh.vertices_m.size();
  d.triangles = work.mesh.triangles.size();
  d.diagonal_m = work.mesh.diagonal_m();
  d.samples = options.samples.value_or(20000);
  d.seed = options.seed.value_or(1);
  d.threads = static_cast<int>(options.threads.value_or(0));
  d.machine = io::this_machine();
  d.build = io::this_build();
  const Result<MeshReport> report = assess_mesh(work.mesh, d.threads);
  if (!report) return in_file(d.mesh, report.error());
  d.report = report.value().text;
  d.closed = report.value().edges.closed();
  d.volume_m3 = report.value().volume_m3;
  // What encloses nothing is a shell, asked for or not.
  d.solidity = options.shell ? Solidity::Shell : report.value().solidity;
  return Done{};
}

Result<TreeWork> begin_work(const TreeOptions& options) {
  TreeWork work;
  work.document.mesh = options.meshes.front();
  MeshReadOptions reading;
  reading.scale = options.scale.value_or(1.0);
  Result<TriangleMesh> mesh = read_mesh(work.document.mesh, reading, &work.document.repair);
  if (!mesh) return mesh.error();
  const Status described = describe(std::move(mesh).value(), options, work);
  if (!described) return described.error();
  return work;
}

/// Measures the tree and adds both to the work.
Status add_tree(SphereTree tree, io::MeasuredTree measured, const std::stop_token& stop, TreeWork& work) {
  io::TreeDocument& d = work.document;
  Result<std::vector<TreeLevelFigures>> levels =
      measure_tree_quality(tree, work.mesh, {d.samples, d.seed, d.solidity, d.threads, stop});
  if (!levels && levels.error().kind == ErrorKind::Cancelled) return stopped_error();
  if (!levels) return in_file(measured.file.empty() ? d.mesh : measured.file, levels.error());
  measured.levels = std::move(levels).value();
  measured.nodes = tree.node_count();
  measured.bytes = io::bytes_of(tree);
  d.trees.push_back(std::move(measured));
  work.trees.push_back(std::move(tree));
  return Done{};
}

/// By the ending of the file.
Result<SphereTree> read_any(const std::filesystem::path& file, const std::stop_token& stop) {
  const std::optional<TreeFormat> format = tree_format_of(file);
  if (!format) return bad_input(fmt::format("{}: the ending must be .sph, .urdf, .yml, .yaml or .json", file.string()));
  if (*format == TreeFormat::Sph) return read_sph(file);
  const Result<std::vector<Sphere>> spheres = read_spheres(file);
  if (!spheres) return spheres.error();
  Result<SphereTree> tree = tree_of_spheres(spheres.value(), {.stop = stop});
  return tree ? std::move(tree) : in_file(file.string(), tree.error());
}

Status add_file(const std::string& file, std::optional<std::uint64_t> level, const std::stop_token& stop,
                TreeWork& work) {
  Result<SphereTree> tree = read_tree(file, level, stop);
  if (!tree) return tree.error();
  io::MeasuredTree measured;
  measured.file = file;
  measured.depth = tree.value().depth();
  return add_tree(std::move(tree).value(), std::move(measured), stop, work);
}

/// Builds the tree of the mesh and measures it; `said` is what the progress says.
Status add_built(const TreeOptions& options, const std::string& said, Progress& progress,
                 const parallel::Interrupt& interrupt, TreeWork& work) {
  progress.say(said);
  TreeBuildOptions build = build_options(options, work.document.solidity);
  build.stop = interrupt.token();
  build.progress = [&](double share) { progress.share(said, share); };
  io::MeasuredTree measured;
  measured.depth = build.depth;
  measured.preset = build.preset;
  measured.cost.emplace();
  Result<SphereTree> tree = build_measured(work.mesh, build, *measured.cost);
  if (interrupt.asked()) return stopped_error();
  if (!tree) return in_file(work.document.mesh, tree.error());
  progress.say("measuring the tree");
  return add_tree(std::move(tree).value(), std::move(measured), interrupt.token(), work);
}

}  // namespace

Result<TreeWork> do_mesh_work(TriangleMesh mesh, const std::string& name, const TreeOptions& options,
                              Progress& progress, const parallel::Interrupt& interrupt) {
  TreeWork work;
  work.document.mesh = name;
  Status done = describe(std::move(mesh), options, work);
  if (done) done = add_built(options, fmt::format("building the tree of {}", name), progress, interrupt, work);
  if (!done) return done.error();
  if (interrupt.asked()) return stopped_error();
  return work;
}

Result<SphereTree> build_measured(const TriangleMesh& mesh, const TreeBuildOptions& options, io::TreeBuildCost& cost) {
  forget_peak_memory();
  const double cpu_ms = process_cpu_ms();
  const auto start = std::chrono::steady_clock::now();
  Result<SphereTree> tree = build_sphere_tree(mesh, options);
  cost.wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  cost.cpu_ms = process_cpu_ms() - cpu_ms;
  cost.peak_bytes = peak_memory_bytes();
  return tree;
}

Result<SphereTree> read_tree(const std::filesystem::path& file, std::optional<std::uint64_t> level,
                             const std::stop_token& stop) {
  Result<SphereTree> tree = read_any(file, stop);
  if (!tree || level.value_or(0) <= tree.value().depth()) return tree;
  return bad_input(fmt::format("{}: has no level {}, its deepest is {}", file.string(), *level, tree.value().depth()));
}

Result<TreeWork> do_tree_work(const TreeOptions& options, Progress& progress, const parallel::Interrupt& interrupt) {
  progress.say("reading the mesh");
  Result<TreeWork> begun = begin_work(options);
  if (!begun) return begun;
  TreeWork& work = begun.value();
  if (options.tree.empty()) {
    const Status added = add_built(options, "building the tree", progress, interrupt, work);
    if (!added) return added.error();
  }
  // The level is that of what is written, which is the first tree.
  const std::pair<const std::string&, std::optional<std::uint64_t>> files[] = {{options.tree, options.level},
                                                                               {options.compare, {}}};
  for (const auto& [file, level] : files) {
    if (file.empty()) continue;
    if (interrupt.asked()) return stopped_error();
    progress.say(fmt::format("measuring {}", file));
    const Status added = add_file(file, level, interrupt.token(), work);
    if (!added) return added.error();
  }
  if (interrupt.asked()) return stopped_error();
  return begun;
}

}  // namespace poise::app
