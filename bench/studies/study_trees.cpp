// SPDX-License-Identifier: MIT
#include "studies/study_trees.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "parallel/interrupt.h"
#include "poise/types.h"
#include "scene/result_file.h"
#include "studies/child_command.h"
#include "studies/study_meshes.h"
#include "studies/trees_document.h"

namespace poise::app {
namespace {

Status check(const StudyTreesOptions& o) {
  if (o.most && !o.scaling) return bad_input("--most needs --scaling");
  if (o.scaling && !o.meshes.empty()) return bad_input("MESH has no meaning with --scaling, which makes its own");
  const auto to_stdout = std::ranges::count(std::vector{o.json, o.markdown, o.csv}, "-");
  if (to_stdout > 1) return bad_input("only one of --json, --markdown and --csv can go to the standard output");
  for (const std::string& mesh : o.meshes.empty() ? std::vector<std::string>{""} : o.meshes) {
    const Status apart =
        check_outputs({{"--json", o.json}, {"--markdown", o.markdown}, {"--csv", o.csv}}, {{"MESH", mesh}});
    if (!apart) return apart;
  }
  return Done{};
}

std::vector<std::string> arguments_of(const StudyTreesOptions& o, const StudyMesh& mesh, const std::string& preset) {
  std::vector<std::string> words{"tree", mesh.file.string(), "--json", "-", "--preset", preset};
  if (o.quiet) words.emplace_back("--quiet");
  const std::pair<const char*, const std::optional<std::uint64_t>*> numbers[] = {
      {"--depth", &o.depth}, {"--threads", &o.threads}, {"--seed", &o.seed}, {"--samples", &o.samples}};
  for (const auto& [name, value] : numbers) {
    if (*value) words.insert(words.end(), {name, std::to_string(**value)});
  }
  return words;
}

Result<io::TreesRow> make_row(const StudyTreesOptions& options, const StudyMesh& mesh, const std::string& preset,
                              const parallel::Interrupt& interrupt) {
  const Result<ChildResult> child = run_child(arguments_of(options, mesh, preset), interrupt);
  if (!child) return child.error();
  if (interrupt.asked()) return stopped_error();
  io::TreesRow row;
  if (child.value().exit_code == kExitDone) {
    Result<io::TreesRow> read = io::row_of_tree_json(child.value().out);
    if (!read) return read.error();
    row = std::move(read).value();
  } else {
    row.refusal = fmt::format("no tree: exit code {}", child.value().exit_code);
  }
  row.mesh = mesh.name;
  row.file = options.scaling ? "" : mesh.file.string();
  return row;
}

Status write_all(const StudyTreesOptions& o, const io::TreesDocument& document) {
  if (o.page_charts != nullptr) *o.page_charts = io::trees_charts(document);
  Status written = write_to(o.json, io::trees_json(document));
  add_failure(write_to(o.markdown, io::trees_markdown(document)), written);
  add_failure(write_to(o.csv, io::trees_csv(document)), written);
  const bool taken = o.json == "-" || o.markdown == "-" || o.csv == "-";
  if (!taken && !o.quiet) add_failure(io::write_stdout(io::trees_table(document)), written);
  return written;
}

io::TreesDocument begin_document(const StudyTreesOptions& options) {
  io::TreesDocument d;
  d.study = options.scaling ? "scaling" : "meshes";
  d.samples = options.samples.value_or(20000);
  d.seed = options.seed.value_or(1);
  d.threads = static_cast<int>(options.threads.value_or(0));
  d.machine = io::this_machine();
  d.build = io::this_build();
  return d;
}

int study(const StudyTreesOptions& options, const std::vector<StudyMesh>& meshes, Progress& progress,
          const parallel::Interrupt& interrupt) {
  const std::vector<std::string> presets =
      options.presets.empty() ? std::vector<std::string>{"default"} : options.presets;
  io::TreesDocument document = begin_document(options);
  for (const StudyMesh& mesh : meshes) {
    for (const std::string& preset : presets) {
      progress.say(fmt::format("tree {} of {}: {}, {}", document.rows.size() + 1, meshes.size() * presets.size(),
                               mesh.name, preset));
      Result<io::TreesRow> row = make_row(options, mesh, preset, interrupt);
      if (!row) {
        progress.end();
        return refuse("study trees", row.error());
      }
      document.rows.push_back(std::move(row).value());
    }
  }
  progress.end();
  const Status written = write_all(options, document);
  if (!written) return refuse("study trees", written.error());
  const bool any = std::ranges::any_of(document.rows, [](const io::TreesRow& row) { return row.refusal.empty(); });
  return any ? kExitDone : refuse("study trees", kExitBadInput, "no mesh gave a tree");
}

}  // namespace

void add_study_trees_options(CLI::App& command, StudyTreesOptions& o) {
  command.add_option("mesh", o.meshes, "Meshes instead of those of the docs")->type_name("MESH");
  command.add_flag("--scaling", o.scaling, "Instead of meshes, one made surface with 1,000 to 1,000,000 triangles");
  add_whole(command, "--most", o.most, 1000, 20000000,
            "With --scaling: the largest number of triangles (default 1000000)");
  command.add_option("--preset", o.presets, "fast, default or best; may be given several times (default default)")
      ->check(CLI::IsMember({"fast", "default", "best"}))
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("NAME");
  add_whole(command, "--depth", o.depth, 0, kMaxTreeDepth, "Levels below the root (default 3)");
  add_whole(command, "--samples", o.samples, 1, 100000000, "Samples for each figure (default 20000)");
  add_whole(command, "--seed", o.seed, 0, UINT64_MAX, "Of the search and of the samples (default 1)");
  add_whole(command, "--threads", o.threads, 0, 256, "Threads of a build, 0 = as many as the machine has (default 0)");
  add_path(command, "--json", o.json, "Write the rows as JSON (poise.trees/1), - for the standard output");
  add_path(command, "--markdown", o.markdown, "Write the table for docs, - for the standard output");
  add_path(command, "--csv", o.csv, "Write a line a mesh and level, - for the standard output");
  command.add_flag("--quiet", o.quiet, "No table and no progress");
  command.footer(
      "Examples:\n"
      "  poise study trees --markdown trees.md                    the table of docs/sphere-trees.md\n"
      "  poise study trees models/*.obj --preset fast --preset best --csv -\n"
      "  poise study trees --scaling --threads 1 --json scaling.json\n\n"
      "Each tree is built in a process of its own: CPU time is that of all its threads, memory the largest that was "
      "resident\n"
      "while it was built, the mesh included. Exit codes as of poise tree.");
}

int study_trees(const StudyTreesOptions& options) {
  const Status sound = check(options);
  if (!sound) return refuse("study trees", kExitBadUsage, sound.error().message);
  const Status writable = can_write({options.json, options.markdown, options.csv});
  if (!writable) return refuse("study trees", writable.error());
  Progress progress(!options.quiet);
  const parallel::Interrupt interrupt;
  if (options.scaling) {
    progress.say("making the meshes");
    const Result<ScalingMeshes> made = ScalingMeshes::make(options.most.value_or(1000000));
    if (!made) {
      progress.end();
      return refuse("study trees", made.error());
    }
    return study(options, made.value().meshes(), progress, interrupt);
  }
  if (!options.meshes.empty()) return study(options, named_study_meshes(options.meshes), progress, interrupt);
  std::vector<std::string> missing;
  const std::vector<StudyMesh> meshes = default_study_meshes(missing);
  for (const std::string& name : missing) print_error("poise study trees: not installed, left out: {}\n", name);
  return study(options, meshes, progress, interrupt);
}

}  // namespace poise::app
