// SPDX-License-Identifier: MIT
#include "studies/study_rest.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "accuracy/small_world.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "parallel/interrupt.h"
#include "poise/assets/mesh_file.h"
#include "studies/study_meshes.h"

namespace poise::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kDrops = 4;
constexpr std::uint64_t kMostDrops = 1000;
constexpr std::uint64_t kDepth = 3;
// Of the drops.
constexpr double kDropSizeM = 0.3;     // the longest side of the box around the mesh
constexpr double kDropHeightM = 0.05;  // of the lowest vertex
constexpr double kDropFrameS = 1.0 / 60;
constexpr std::uint64_t kDropFrames = 1200;
constexpr std::uint64_t kLastFrames = 120;  // in which it must not move
constexpr double kAtRestMps = 1e-6;

// A mesh by which drops are made.
struct Dropped {
  StudyMesh mesh;
  std::vector<Vec3> vertices_m;  // scaled
  double scale = 1;
};

Result<Dropped> read_dropped(const StudyMesh& mesh) {
  Result<TriangleMesh> read = read_mesh(mesh.file, {});
  if (!read) return read.error();
  Dropped dropped{mesh, std::move(read.value().vertices_m), 1};
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : dropped.vertices_m) box.extend(vertex);
  const double longest = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  if (!(longest > 0)) return bad_input(fmt::format("{}: has no extent", mesh.file.string()));
  dropped.scale = kDropSizeM / longest;
  for (Vec3& vertex : dropped.vertices_m) vertex *= dropped.scale;
  return dropped;
}

// The mesh over a plane: as in its file, or turned by a random rotation.
Result<Scene> scene_of(const Dropped& dropped, std::uint64_t drop, std::uint64_t depth) {
  const Quat turn = drop == 0 ? Quat(1, 0, 0, 0) : accuracy::Random(drop).turn();
  double lowest_m = std::numeric_limits<double>::max();
  for (const Vec3& vertex : dropped.vertices_m) lowest_m = std::min(lowest_m, (turn * vertex).z());
  const Json scene = {
      {"name", "rest"},
      {"dt_s", kDropFrameS},
      {"frames", kDropFrames},
      {"gravity_mps2", {0, 0, -9.81}},
      {"materials", {{"m", {{"friction", 0.5}}}}},
      {"shapes",
       {{"mesh", {{"mesh", {{"file", dropped.mesh.file.string()}, {"scale", dropped.scale}, {"depth", depth}}}}},
        {"floor", {{"plane", {{"normal", {0, 0, 1}}}}}}}},
      {"bodies",
       {{{"shape", "mesh"},
         {"material", "m"},
         {"position_m", {0, 0, kDropHeightM - lowest_m}},
         {"orientation_wxyz", {turn.w(), turn.x(), turn.y(), turn.z()}}},
        {{"shape", "floor"}, {"material", "m"}, {"static", true}}}}};
  return parse_scene(scene.dump(), dropped.mesh.name, "");
}

// The largest |v| + r |w| in the last frames of a drop, r the bounding radius.
Result<double> last_speed_mps(const Scene& scene, const SceneRunOptions& start, const StepInput& input) {
  Result<SceneRun> made = SceneRun::create(scene, start);
  if (!made) return made.error();
  SceneRun& run = made.value();
  const double radius_m = run.shapes()[run.bodies()[0].shape]->bounding_radius_m;
  double fastest_mps = 0;
  for (std::uint64_t frame = 0; frame < scene.frames; ++frame) {
    if (run.world().step(input).status != StepStatus::Done)
      return bad_input("the step was refused: its input is out of range");
    if (frame + kLastFrames < scene.frames) continue;
    const BodyState state = run.world().state(run.bodies()[0].id).value();
    fastest_mps = std::max(fastest_mps, state.velocity_mps.norm() + radius_m * state.angular_velocity_radps.norm());
  }
  return fastest_mps;
}

std::vector<io::StudyColumn> columns_of(std::uint64_t depth) {
  std::vector<io::StudyColumn> columns = {{"mesh", "mesh"}};
  for (std::uint64_t level = 1; level <= depth + 1; ++level) {
    const std::string name = level <= depth ? fmt::format("level_{}", level) : "polygons";
    const std::string title = level <= depth ? fmt::format("level {}", level) : "polygons";
    columns.push_back({name + "_moving", title + ": still moving"});
    columns.push_back({name + "_fastest_mmps", "mm/s", 3});
  }
  return columns;
}

// The charts of the page: a line for each way to refine, against the meshes.
std::vector<LineChart> rest_charts(const io::StudyTable& table) {
  LineChart chart{"rest", "drops that still move", "Which meshes do not come to rest on a plane", "mesh", {}};
  std::vector<std::string> names;
  for (const auto& row : table.rows) names.push_back(std::get<std::string>(row[0]));
  for (std::size_t c = 1; c < table.columns.size(); c += 2) {
    const std::string& title = table.columns[c].title;
    ChartLine line{title.substr(0, title.find(':')), {}, LineMarks::Dots};
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (const auto* moving = std::get_if<std::uint64_t>(&table.rows[i][c]))
        line.points.push_back({static_cast<double>(i), static_cast<double>(*moving), {}, {}});
    }
    chart.lines.push_back(std::move(line));
  }
  name_places(chart, std::move(names), "mesh");
  return {std::move(chart)};
}

// All drops of one mesh.
Result<std::vector<io::StudyCell>> row_of(const StudyRestOptions& o, const StudyMesh& mesh,
                                          const parallel::Interrupt& interrupt,
                                          const std::function<void(double)>& progress) {
  const std::uint64_t drops = o.drops.value_or(kDrops);
  const std::uint64_t depth = o.depth.value_or(kDepth);
  const Result<Dropped> dropped = read_dropped(mesh);
  if (!dropped) return dropped.error();
  SceneRunOptions start;
  start.world.executor = ExecutorKind::Serial;
  start.tree_cache = tree_cache_settings(o.common.tree_cache).value();
  start.stop = interrupt.token();
  std::vector<io::StudyCell> cells{mesh.name};
  for (std::uint64_t level = 1; level <= depth + 1; ++level) {
    StepInput input;
    input.dt_s = kDropFrameS;
    input.max_level = static_cast<Level>(std::min(level, depth));
    input.polygons = level > depth;
    std::uint64_t moving = 0;
    double fastest_mps = 0;
    for (std::uint64_t drop = 0; drop < drops; ++drop) {
      if (interrupt.asked()) return stopped_error();
      progress(static_cast<double>((level - 1) * drops + drop) / static_cast<double>((depth + 1) * drops));
      const Result<Scene> scene = scene_of(dropped.value(), drop, depth);
      if (!scene) return scene.error();
      const Result<double> speed_mps = last_speed_mps(scene.value(), start, input);
      if (!speed_mps) return interrupt.asked() ? stopped_error() : speed_mps.error();
      moving += speed_mps.value() < kAtRestMps ? 0U : 1U;
      fastest_mps = std::max(fastest_mps, speed_mps.value());
    }
    cells.insert(cells.end(), {moving, 1e3 * fastest_mps});
  }
  return cells;
}

Result<io::StudyTable> measured(const StudyRestOptions& o, const std::vector<StudyMesh>& meshes, Progress& progress) {
  io::StudyTable table = begin_study("rest", "poise study rest");
  table.columns = columns_of(o.depth.value_or(kDepth));
  table.facts = {{"drops", o.drops.value_or(kDrops)}, {"size_m", kDropSizeM},
                 {"height_m", kDropHeightM},          {"frames", kDropFrames},
                 {"last_frames", kLastFrames},        {"at_rest_mmps", 1e3 * kAtRestMps}};
  const parallel::Interrupt interrupt;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    Result<std::vector<io::StudyCell>> row = row_of(o, meshes[i], interrupt, [&](double share) {
      progress.share(meshes[i].name, (static_cast<double>(i) + share) / static_cast<double>(meshes.size()));
    });
    if (!row) return row.error();
    table.rows.push_back(std::move(row).value());
  }
  return table;
}

}  // namespace

void add_study_rest_options(CLI::App& command, StudyRestOptions& o) {
  command.add_option("mesh", o.meshes, "Meshes instead of those of the docs")->type_name("MESH");
  add_whole(command, "--drops", o.drops, 1, kMostDrops,
            fmt::format("Drops of each mesh and level: one as in its file, others turned (default {})", kDrops));
  add_whole(command, "--depth", o.depth, 1, kMaxTreeDepth, fmt::format("Levels of the trees (default {})", kDepth));
  add_path(command, "--json", o.common.json, "Write the rows as JSON, - for the standard output");
  add_path(command, "--markdown", o.common.markdown, "Write the table for docs, - for the standard output");
  add_tree_cache_options(command, o.common.tree_cache);
  command.add_flag("--quiet", o.common.quiet, "No table and no progress");
  command.footer(
      "Each mesh is scaled to 0.3 m and dropped from 5 cm on a plane with a friction of 0.5, alone, 20 s at 60 Hz,\n"
      "without a budget. A drop still moves if |v| + r |w| is 1e-6 m/s or more in any of the last two seconds (r: its\n"
      "bounding radius); the largest is beside. Exit codes as of poise run; a body that moves is no failure.");
}

int study_rest(const StudyRestOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound)
    return refuse("study rest", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  std::vector<std::string> missing;
  const std::vector<StudyMesh> meshes = o.meshes.empty() ? default_study_meshes(missing) : named_study_meshes(o.meshes);
  for (const std::string& name : missing) print_error("poise study rest: not installed, left out: {}\n", name);
  Progress progress(!o.common.quiet);
  const Result<io::StudyTable> table = measured(o, meshes, progress);
  progress.end();
  if (!table) return refuse("study rest", table.error());
  const Status written = write_study(o.common, table.value(), rest_charts(table.value()), 1);
  return written ? kExitDone : refuse("study rest", written.error());
}

}  // namespace poise::app
