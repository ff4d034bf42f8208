// SPDX-License-Identifier: MIT
#include "app/tree_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/exit_codes.h"
#include "app/output_files.h"
#include "app/progress.h"
#include "app/tree_options.h"
#include "app/tree_table.h"
#include "app/tree_verdict.h"
#include "app/tree_work.h"
#include "io/atomic_file.h"
#include "io/picture.h"
#include "io/tree_document.h"
#include "io/tree_picture.h"
#include "parallel/interrupt.h"
#include "poise/tree_formats.h"

namespace poise::app {
namespace {

int refuse(int code, const std::string& message) {
  fmt::print(stderr, "poise tree: {}\n", message);
  return code;
}
int refuse(const Error& error) { return refuse(exit_code_of(error), error.message); }

Status save_tree(const TreeOptions& options, const SphereTree& tree) {
  const auto level = static_cast<Level>(options.level.value_or(tree.depth()));
  return write_tree(tree, level, *tree_format_of(options.output), std::filesystem::path(options.output).stem().string(),
                    options.output);
}

Status save_picture(const TreeOptions& options, const TreeWork& work) {
  std::vector<io::DrawnTree> trees;
  for (std::size_t i = 0; i < work.trees.size(); ++i) {
    const std::string& file = work.document.trees[i].file;
    const std::string name = file.empty() ? "built here" : std::filesystem::path(file).filename().string();
    trees.push_back({&work.trees[i], work.trees.size() > 1 ? name : ""});
  }
  io::TreePictureSettings settings;
  settings.up = axis_of(up_of(options));
  if (options.front) settings.front = axis_of(*options.front);
  settings.solidity = work.document.solidity;
  settings.threads = work.document.threads;
  const Result<io::Image> image = io::draw_trees(work.mesh, trees, settings);
  if (!image) return image.error();
  const Result<std::string> png = io::png_bytes(image.value());
  return png ? io::write_file(options.picture, png.value()) : Status(png.error());
}

Status save_all(const TreeOptions& options, const TreeWork& work) {
  Status written = Done{};
  if (!options.output.empty()) written = save_tree(options, work.trees.front());
  if (written && !options.picture.empty()) written = save_picture(options, work);
  if (written && !options.json.empty()) {
    const std::string text = io::tree_json(work.document);
    written = options.json == "-" ? io::write_stdout(text) : io::write_file(options.json, text);
  }
  // The standard output is one document: the JSON where it was asked for, else the table.
  if (written && !options.quiet && options.json != "-") written = io::write_stdout(tree_table(work.document));
  return written;
}

int judge(const TreeOptions& options) {
  const Status writable = can_write({options.output, options.json, options.picture});
  if (!writable) return refuse(writable.error());
  Progress progress(!options.quiet);
  const parallel::Interrupt interrupt;
  const Result<TreeWork> work = do_tree_work(options, progress, interrupt);
  if (work && !options.picture.empty()) progress.say("drawing");
  const Status written = work ? save_all(options, work.value()) : Status(Done{});
  progress.end();
  if (!work) return refuse(work.error());
  if (!written) return refuse(written.error());
  const bool leaking = std::ranges::any_of(work.value().document.trees, [&](const io::JudgedTree& tree) {
    return io::leaks(tree, work.value().document.solidity);
  });
  return options.require_coverage && leaking ? refuse(kExitRequirementFailed, "--require-coverage: a tree leaks")
                                             : kExitDone;
}

int convert(const TreeOptions& options) {
  const Result<SphereTree> tree = read_tree(options.tree, options.level);
  if (!tree) return refuse(tree.error());
  const Status written = save_tree(options, tree.value());
  return written ? kExitDone : refuse(written.error());
}

int tree_command(const TreeOptions& options) {
  const Status sound = check_tree_options(options);
  if (!sound) return refuse(kExitBadUsage, sound.error().message);
  switch (task_of(options)) {
    case TreeTask::Verdict:
      return tell_verdicts(options);
    case TreeTask::Convert:
      return convert(options);
    case TreeTask::Judge:
      break;
  }
  return judge(options);
}

}  // namespace

void add_tree_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("tree", "Build, judge, compare, convert and draw sphere trees of meshes");
  auto options = std::make_shared<TreeOptions>();
  add_tree_options(*command, *options);
  command->callback([options, &exit_code] { exit_code = tree_command(*options); });
}

}  // namespace poise::app
