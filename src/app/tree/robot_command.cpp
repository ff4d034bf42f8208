// SPDX-License-Identifier: MIT
#include "app/tree/robot_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/files/output_files.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/tree/robot_files.h"
#include "app/tree/tree_document.h"
#include "app/tree/tree_work.h"
#include "assets/files/text_file.h"
#include "assets/tree/urdf_robot.h"
#include "parallel/interrupt.h"
#include "poise/assets/tree_formats.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

/// As many bytes as a URDF of spheres may have.
constexpr std::uint64_t kMostUrdfBytes = 64ULL << 20U;

/// A robot, the trees of its links, and what is written of them.
struct RobotWork {
  std::string text;
  std::vector<io::RobotLink> links;
  std::vector<std::optional<std::vector<Sphere>>> spheres;  ///< of the level that is written, beside `links`
};

std::vector<Sphere> spheres_of(const SphereTree& tree, Level level) {
  std::vector<Sphere> spheres;
  for (const NodeIndex node : tree.nodes_at(level)) spheres.push_back(tree.sphere(node));
  return spheres;
}

Result<RobotWork> do_robot_work(const TreeOptions& options, Progress& progress, const parallel::Interrupt& interrupt) {
  const std::string& file = options.meshes.front();
  const auto refused = [&](const Error& error) {
    return Error{error.kind, error.kind == ErrorKind::Cancelled ? error.message : file + ": " + error.message};
  };
  RobotWork work;
  Result<std::string> text = geometry::read_text_file(file, kMostUrdfBytes);
  if (!text) return text.error();
  work.text = std::move(text).value();
  const Result<std::vector<geometry::UrdfLink>> links = geometry::urdf_links(work.text);
  if (!links) return refused(links.error());
  const RobotFolders folders{std::filesystem::path(file).parent_path(), options.packages};
  // Every mesh is read before the first tree is built, so that a missing file is told at once.
  std::vector<TriangleMesh> meshes;
  for (const geometry::UrdfLink& link : links.value()) {
    progress.say(fmt::format("reading link {}", link.name));
    Result<TriangleMesh> mesh =
        link.parts.empty() || link.only_spheres() ? TriangleMesh{} : mesh_of_link(link, folders);
    if (!mesh) return refused(mesh.error());
    meshes.push_back(std::move(mesh).value());
  }
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const geometry::UrdfLink& link = links.value()[i];
    io::RobotLink found{link.name, link.from_visual ? "visual" : "collision", {}};
    work.spheres.emplace_back();
    if (meshes[i].triangles.empty()) {
      found.shapes = link.parts.empty() ? "none" : "spheres";
    } else {
      Result<TreeWork> one =
          do_mesh_work(std::move(meshes[i]), fmt::format("link '{}'", link.name), options, progress, interrupt);
      if (!one) return refused(one.error());
      const SphereTree& tree = one.value().trees.front();
      work.spheres.back() = spheres_of(tree, static_cast<Level>(options.level.value_or(tree.depth())));
      found.tree = std::move(one.value().document);
    }
    work.links.push_back(std::move(found));
  }
  return work;
}

/// What stands in the column of shapes: of a shell it says so, since it has no inside.
std::string shapes_of(const io::RobotLink& link) {
  return link.tree && link.tree->solidity == Solidity::Shell ? link.shapes + ", shell" : link.shapes;
}

std::string robot_table(const std::string& file, const std::vector<io::RobotLink>& links) {
  std::size_t width = 4;
  for (const io::RobotLink& link : links) width = std::max(width, link.name.size());
  std::string text;
  const auto out = std::back_inserter(text);
  const auto trees = std::ranges::count_if(links, [](const io::RobotLink& link) { return link.tree.has_value(); });
  fmt::format_to(out, "{}: {} links, {} with a tree\n\n", file, links.size(), trees);
  fmt::format_to(out, "{:<{}}  {:<16} {:>5} {:>8} {:>22} {:>22} {:>10} {:>10} {:>8}\n", "", width, "", "", "",
                 "largest protrusion", "mean protrusion", "surface", "inside", "volume");
  fmt::format_to(out, "{:<{}}  {:<16} {:>5} {:>8} {:>12} {:>9} {:>12} {:>9} {:>10} {:>10} {:>8}\n", "link", width,
                 "shapes", "level", "spheres", "m", "% diag", "m", "% diag", "% covered", "% covered", "ratio");
  for (const io::RobotLink& link : links) {
    std::string head = fmt::format("{:<{}}  {:<16}", link.name, width, shapes_of(link));
    if (!link.tree) fmt::format_to(out, "{}\n", head.substr(0, head.find_last_not_of(' ') + 1));
    if (!link.tree) continue;
    const io::TreeDocument& d = *link.tree;
    const bool shell = d.solidity == Solidity::Shell;
    for (const TreeLevelFigures& f : d.trees.front().levels) {
      fmt::format_to(out, "{} {:>5} {:>8} {:>12.6g} {:>9.3f} {:>12.6g} {:>9.3f} {:>10.4f} {:>10} {:>8}{}\n", head,
                     f.level, f.spheres, f.protrusion_max_m, 100 * f.protrusion_max_m / d.diagonal_m,
                     f.protrusion_mean_m, 100 * f.protrusion_mean_m / d.diagonal_m, 100 * f.surface_coverage,
                     shell ? "-" : fmt::format("{:.4f}", 100 * f.inside_coverage),
                     shell ? "-" : fmt::format("{:.3f}", f.volume_ratio), io::leaks(f, d.solidity) ? "  leaks" : "");
      head.assign(width + 18, ' ');
    }
  }
  return text;
}

Status save(const TreeOptions& options, const RobotWork& work) {
  Status written = Done{};
  if (!options.output.empty()) {
    const Result<std::string> robot = geometry::with_collision_spheres(work.text, work.spheres);
    if (!robot) return bad_input(fmt::format("{}: {}", options.meshes.front(), robot.error().message));
    written = io::write_file(options.output, robot.value());
  }
  if (!options.json.empty())
    add_failure(write_to(options.json, io::robot_json(options.meshes.front(), work.links)), written);
  if (!options.quiet && options.json != "-")
    add_failure(io::write_stdout(robot_table(options.meshes.front(), work.links)), written);
  return written;
}

}  // namespace

int measure_robot(const TreeOptions& options) {
  const parallel::Interrupt interrupt;
  const Status writable = can_write({options.output, options.json});
  if (!writable) return refuse("tree", writable.error());
  Progress progress(!options.quiet);
  const Result<RobotWork> work = do_robot_work(options, progress, interrupt);
  progress.end();
  if (!work) return refuse("tree", work.error());
  const Status written = save(options, work.value());
  if (!written) return refuse("tree", written.error());
  const bool leaking = std::ranges::any_of(work.value().links, [](const io::RobotLink& link) {
    return link.tree && io::leaks(link.tree->trees.front(), link.tree->solidity);
  });
  return options.require_coverage && leaking
             ? refuse("tree", kExitRequirementFailed, "--require-coverage: the tree of a link leaks")
             : kExitDone;
}

}  // namespace poise::app
