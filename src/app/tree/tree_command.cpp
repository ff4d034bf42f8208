// SPDX-License-Identifier: MIT
#include "app/tree/tree_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/files/output_files.h"
#include "app/picture/picture.h"
#include "app/picture/tree_picture.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/tree/mesh_report_table.h"
#include "app/tree/robot_command.h"
#include "app/tree/tree_document.h"
#include "app/tree/tree_options.h"
#include "app/tree/tree_table.h"
#include "app/tree/tree_work.h"
#include "parallel/interrupt.h"
#include "poise/assets/tree_formats.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

Status save_tree(const TreeOptions& options, const SphereTree& tree) {
  const auto level = static_cast<Level>(options.level.value_or(tree.depth()));
  return write_tree(tree, level, *tree_format_of(options.output), std::filesystem::path(options.output).stem().string(),
                    options.output);
}

Status save_picture(const TreeOptions& options, const TreeWork& work, const std::string& file, bool dark) {
  if (file.empty()) return Done{};
  std::vector<io::DrawnTree> trees;
  for (std::size_t i = 0; i < work.trees.size(); ++i) {
    const std::string& read = work.document.trees[i].file;
    const std::string name = read.empty() ? "built here" : std::filesystem::path(read).filename().string();
    trees.push_back({&work.trees[i], work.trees.size() > 1 ? name : ""});
  }
  io::TreePictureSettings settings;
  settings.up = axis_of(up_of(options));
  if (options.front) settings.front = axis_of(*options.front);
  settings.solidity = work.document.solidity;
  settings.dark = dark;
  settings.threads = work.document.threads;
  const Result<io::Image> image = io::draw_trees(work.mesh, trees, settings);
  if (!image) return image.error();
  const Result<std::string> png = io::png_bytes(image.value());
  return png ? io::write_file(file, png.value()) : Status(png.error());
}

Status save_all(const TreeOptions& options, const TreeWork& work) {
  Status written = Done{};
  if (!options.output.empty()) written = save_tree(options, work.trees.front());
  if (!options.json.empty()) add_failure(write_to(options.json, io::tree_json(work.document)), written);
  add_failure(save_picture(options, work, options.picture, false), written);
  add_failure(save_picture(options, work, options.picture_dark, true), written);
  // The standard output is one document: the JSON where it was asked for, else the table.
  if (!options.quiet && options.json != "-") add_failure(io::write_stdout(tree_table(work.document)), written);
  return written;
}

int measure(const TreeOptions& options) {
  const parallel::Interrupt interrupt;
  const Status writable = can_write({options.output, options.json, options.picture, options.picture_dark});
  if (!writable) return refuse("tree", writable.error());
  Progress progress(!options.quiet);
  const Result<TreeWork> work = do_tree_work(options, progress, interrupt);
  if (work && draws(options)) progress.say("drawing");
  const Status written = work ? save_all(options, work.value()) : Status(Done{});
  progress.end();
  if (!work) return refuse("tree", work.error());
  if (!written) return refuse("tree", written.error());
  const bool leaking = std::ranges::any_of(work.value().document.trees, [&](const io::MeasuredTree& tree) {
    return io::leaks(tree, work.value().document.solidity);
  });
  return options.require_coverage && leaking
             ? refuse("tree", kExitRequirementFailed, "--require-coverage: a tree leaks")
             : kExitDone;
}

int convert(const TreeOptions& options) {
  const Result<SphereTree> tree = read_tree(options.tree, options.level);
  if (!tree) return refuse("tree", tree.error());
  const Status written = save_tree(options, tree.value());
  return written ? kExitDone : refuse("tree", written.error());
}

int tree_command(const TreeOptions& options) {
  const Status sound = check_tree_options(options);
  if (!sound) return refuse("tree", kExitBadUsage, sound.error().message);
  switch (task_of(options)) {
    case TreeTask::Inspect:
      return print_mesh_reports(options);
    case TreeTask::Convert:
      return convert(options);
    case TreeTask::Robot:
      return measure_robot(options);
    case TreeTask::Measure:
      break;
  }
  return measure(options);
}

}  // namespace

void add_tree_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("tree", "Build, measure, compare, convert and draw sphere trees of meshes");
  auto options = std::make_shared<TreeOptions>();
  add_tree_options(*command, *options);
  command->callback([options, &exit_code] { exit_code = tree_command(*options); });
}

}  // namespace poise::app
