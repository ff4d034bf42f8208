// SPDX-License-Identifier: MIT
#include "app/run/run_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <system_error>

#include "app/files/output_files.h"
#include "app/files/scene_input.h"
#include "app/options/option_values.h"
#include "app/options/suggestions.h"
#include "app/process/process_memory.h"
#include "app/process/standard_streams.h"
#include "app/report/report_files.h"
#include "app/run/body_table.h"
#include "parallel/executor.h"
#include "scene/islands_wait_name.h"
#include "scene/policy_file.h"
#include "scene/run/policy_name.h"
#include "world/contact_model_names.h"

namespace poise::app {
namespace {

constexpr double kLongestMs = 1e6;

// A level of the trees, or the word for what lies beneath them.
void add_max_level(CLI::App& command, RunOptions& options) {
  const auto read = [&options](const std::string& text) {
    options.polygons = text == "polygons";
    if (options.polygons) {
      options.max_level = kMaxTreeDepth;
      return;
    }
    std::uint64_t level = 0;
    const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), level);
    if (failure != std::errc{} || stop != text.data() + text.size() || level > kMaxTreeDepth) {
      throw CLI::ValidationError(
          fmt::format("--max-level = {}, must be a whole number from 0 to {}, or polygons", text, kMaxTreeDepth),
          CLI::ExitCodes::ValidationError);
    }
    options.max_level = level;
  };
  command
      .add_option_function<std::string>("--max-level", read,
                                        "Refine no pair beyond this level of its trees; polygons: all levels, then the "
                                        "triangles of meshes (default: the scene's)")
      ->type_name("N|polygons");
}

void add_contact_model(CLI::App& command, RunOptions& options) {
  command.add_option("--contact", options.contact, "Contact model: paper, wrench or fitted (default fitted)")
      ->check(one_of({"paper", "wrench", "fitted"}))
      ->type_name("MODEL");
}

CLI::Validator policy_or_file() {
  const CLI::Validator name = one_of({io::kPolicyNames.begin(), io::kPolicyNames.end()});
  return {[name](std::string& text) { return io::names_policy_file(text) ? std::string() : name(text); }, ""};
}

// Calls check(all files that a run writes).
template <class Check>
Status with_outputs(const RunOptions& options, Check&& check) {
  const std::string page = report_page_of(options.report);
  const std::string bodies = body_table_of(options.states);
  return check({{"--json", options.json},
                {"--states", options.states},
                {"the bodies of --states", bodies},
                {"--frames-csv", options.frames_csv},
                {"--trace", options.trace},
                {"--picture", options.picture.file},
                {"--record", options.record},
                {"--capture", options.capture.file},
                {"--report", page}});
}

}  // namespace

void add_policy_options(CLI::App& command, RunOptions& options) {
  command
      .add_option("--policy", options.policy,
                  fmt::format("What is refined first: {}, or a policy file (docs/priorities.md; default: the scene's)",
                              fmt::join(io::kPolicyNames, ", ")))
      ->check(policy_or_file())
      ->type_name("P|FILE");
  command.add_option("--weight", options.weights, "Exponent of a cue, as closing=2; may be given several times")
      ->type_name("CUE=VALUE");
}

void add_run_options(CLI::App& command, RunOptions& options) {
  constexpr std::uint64_t kMany = std::numeric_limits<std::uint64_t>::max();
  add_scene(command, options.scene);
  add_whole(command, "--frames", options.frames, 1, kMaxSceneFrames,
            "Frames to simulate and measure (default: the scene's)");
  add_whole(command, "--bodies", options.bodies, 1, kMaxSceneBodies, "How many bodies the generators make together");
  add_whole(command, "--warmup", options.warmup, 0, kMaxSceneFrames,
            "Frames before those, simulated and written but kept apart from the figures (default 0)");
  add_number(command, "--deadline", options.deadline_ms, 0, true, kLongestMs,
             "Deadline of a frame in ms (default: the scene's deadline_ms, else its time step)");
  command.add_flag("--paced", options.paced, "Release frames on a fixed grid of the time step instead of back to back");
  add_number(command, "--host-work", options.host_work_ms, 0, false, kLongestMs,
             "Work of the host in ms that is kept free before each deadline");
  add_whole(command, "--threads", options.threads, 0, 256, "Threads, 0 = as many as the machine has (default 0)");
  add_policy_options(command, options);
  add_contact_model(command, options);
  command
      .add_option("--clock", options.clock,
                  "wall: keep deadlines; work: count work, the same bits on any number of threads (default wall)")
      ->check(one_of({"wall", "work"}))
      ->type_name("CLOCK");
  add_whole(command, "--budget-work", options.budget_work, 0, kMany,
            "Refinement a frame in node-pair expansions, with --clock work (default: unlimited)");
  add_max_level(command, options);
  add_switch(
      command, "backtracking", options.backtracking,
      "Answer bodies that move far in a step where they meet something within it, or not (default: the scene's)");
  add_switch(command, "sleeping", options.sleeping,
             "Let bodies at rest fall asleep until something comes near them, or not (default: the scene's)");
  command
      .add_option("--islands-wait", options.islands_wait,
                  "Which islands may wait in a frame that has no time for them: never, near_rest or any (default: the "
                  "scene's, and at most those)")
      ->check(one_of({io::kIslandsWaitNames.begin(), io::kIslandsWaitNames.end()}))
      ->type_name("WHICH");
  add_path(command, "--gaze", options.gaze,
           "Look where this recorded gaze says (CSV: time_s,x_px,y_px), whatever the scene says");
  add_whole(command, "--seed", options.seed, 0, kMany, "Instead of the scene's seed; moves generated bodies too");
  command.add_option("--executor", options.executor, "Threads by tbb, threads or serial (default: tbb where built in)")
      ->check(one_of({"tbb", "threads", "serial"}))
      ->type_name("E");
  add_number(command, "--spin", options.spin_us, 0, false, 1e4,
             "Microseconds that a thread without work looks for it before it sleeps, at most 10000 (default 50)")
      ->type_name("US");
  add_text(command, "--affinity", options.affinity,
           "Bind thread k, the main one as k = 0, to the k-th of these processors, in turn: 0,2 or 0-3 (needs "
           "--executor threads or serial, and "
           "chooses threads); as many threads as processors unless --threads says otherwise")
      ->type_name("LIST");
  add_whole(command, "--realtime", options.realtime, 1, 99,
            "Run the threads under SCHED_FIFO with this priority, where the system permits it (likewise not with "
            "--executor tbb)");
  add_path(command, "--json", options.json, "Write the figures as JSON (poise.run/2), - for the standard output");
  add_path(command, "--states", options.states,
           "Write every body after every frame as CSV, and beside it what each body is (FILE.bodies.csv)");
  add_whole(command, "--states-every", options.states_every, 1, kMaxSceneFrames,
            "With --states: the start and each N-th frame after it only (default 1)");
  add_path(command, "--frames-csv", options.frames_csv, "Write one row a frame as CSV");
  add_path(command, "--trace", options.trace,
           "Write what the threads did when as Chrome trace events (opens in ui.perfetto.dev)");
  add_path(command, "--record", options.record, "Write what each frame decided, for poise replay");
  add_capture_options(command, options.capture);
  add_path(command, "--report", options.report,
           "Write a page into this folder that shows the run: charts and a replay (docs/viewing.md); its capture goes "
           "there too, unless --capture names a file");
  // No film: drawing between frames would empty the caches of the next one. A capture costs less.
  add_picture_options(command, options.picture,
                      "after the last frame. For a film: --capture, then poise export --frames-dir (docs/pictures.md)");
  command
      .add_option("--require", options.require,
                  "Exit with 1 unless this holds, e.g. 'miss_rate < 0.01 && frame_ms.p99 < 16.7'")
      ->type_name("EXPR");
  add_every(command, "--reference", options.reference_every, kMaxSceneFrames,
            "every=K: compare each K-th measured frame with the same frame done at full depth and to convergence; "
            "such a frame is not done in slices");
  add_time_options(command, options.time);
  add_tree_cache_options(command, options.tree_cache);
  add_max_memory(command, options.max_memory_mib);
  command.add_flag("--quiet", options.quiet, "No progress and no table");
}

Status check_run_options(const RunOptions& options) {
  scheduler::Policy any;
  for (const std::string& weight : options.weights) {
    const Status set = io::set_weight(weight, any);
    if (!set) return bad_input("--weight: " + set.error().message);
  }
  const bool work = options.clock == "work";
  if (options.budget_work && !work) return bad_input("--budget-work needs --clock work");
  if (work && options.deadline_ms) return bad_input("--deadline has no meaning with --clock work");
  if (work && options.paced) return bad_input("--paced has no meaning with --clock work");
  if (work && options.host_work_ms) return bad_input("--host-work has no meaning with --clock work");
  const Status time = check_time_options(options.time, work);
  if (!time) return time;
#ifndef POISE_APP_HAVE_TBB
  if (options.executor == "tbb") return bad_input("--executor tbb: this program was built without oneTBB");
#endif
  if (options.require && options.require->empty()) return bad_input("--require must not be empty");
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.tree_cache);
  if (!cache) return cache.error();
  const Result<std::vector<int>> processors = processor_list(options.affinity);
  if (!processors) return processors.error();
  for (const std::string* path :
       {&options.states, &options.frames_csv, &options.trace, &options.record, &options.report}) {
    if (*path == "-") return bad_input("only --json can go to the standard output");
  }
  if (options.states_every && options.states.empty()) return bad_input("--states-every needs --states");
  const Status captured = check_capture_options(options.capture);
  if (!captured) return captured;
  const Status picture = check_picture_options(options.picture);
  if (!picture) return picture;
  return with_outputs(options, [&](std::initializer_list<NamedFile> outputs) {
    return check_outputs(outputs, {{"SCENE", options.scene}, {"--gaze", options.gaze}, {"--policy", options.policy}});
  });
}

Status check_run_files(const RunOptions& options, const Scene& scene) {
  return with_outputs(options,
                      [&](std::initializer_list<NamedFile> outputs) { return check_scene_files(outputs, scene); });
}

Result<std::vector<int>> processor_list(const std::string& text) {
  constexpr std::size_t kMost = 256;
  std::vector<int> processors;
  const auto wrong = [&] {
    return bad_input(fmt::format("--affinity = {}, must be processors such as 0,2 or 0-3, at most {}", text, kMost));
  };
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto number = [&](int& value) {
    const auto [stop, failure] = std::from_chars(at, end, value);
    const bool good = failure == std::errc{} && value >= 0;
    at = stop;
    return good;
  };
  while (at != end) {
    int first = 0;
    if (!number(first)) return wrong();
    int last = first;
    if (at != end && *at == '-') {
      ++at;
      if (!number(last)) return wrong();
    }
    if (last < first || static_cast<std::size_t>(last - first) >= kMost - std::min(kMost, processors.size()))
      return wrong();
    for (int processor = first; processor <= last; ++processor) processors.push_back(processor);
    if (at == end) break;
    if (*at != ',' || ++at == end) return wrong();
  }
  return processors;
}

ExecutorKind executor_kind(const RunOptions& options) {
  if (options.executor == "serial") return ExecutorKind::Serial;
  if (options.executor == "threads") return ExecutorKind::Threads;
  // oneTBB's threads belong to the whole process and take no place or priority; who asks for it by name is told so.
  if (options.executor.empty() && (!options.affinity.empty() || options.realtime)) return ExecutorKind::Threads;
#ifdef POISE_APP_HAVE_TBB
  return ExecutorKind::Tbb;
#else
  return ExecutorKind::Threads;
#endif
}

Status apply_to_scene(const RunOptions& options, Scene& scene, std::vector<std::string>& errors) {
  scene.sleeping = options.sleeping.value_or(scene.sleeping);
  scene.backtracking = options.backtracking.value_or(scene.backtracking);
  if (io::names_policy_file(options.policy)) {
    const Result<io::PolicyFile> file = io::read_policy_file(options.policy, scene.policy, &errors);
    if (!file) return file.error();
    scene.policy = file.value().policy;
  }
  for (const std::string& weight : options.weights) {
    const Status set = io::set_weight(weight, scene.policy);
    if (!set) return set;
  }
  return Done{};
}

WorldSettings world_settings(const RunOptions& options, const Scene& scene) {
  WorldSettings settings;
  for (const simulation::NamedContactModel& named : simulation::kContactModels) {
    if (options.contact == named.name) settings.contact = named.model;
  }
  settings.policy = scene.policy;
  if (const io::NamedPolicy* named = io::policy_named(options.policy)) settings.policy.kind = named->kind;
  settings.alpha = options.time.alpha.value_or(scene.alpha.value_or(settings.alpha));
  settings.sleeping = scene.sleeping;
  settings.islands_wait = scene.islands_wait;
  for (std::size_t which = 0; which < io::kIslandsWaitNames.size(); ++which) {
    if (options.islands_wait == io::kIslandsWaitNames[which]) settings.islands_wait = static_cast<IslandsWait>(which);
  }
  settings.executor = executor_kind(options);
  settings.processors = processor_list(options.affinity).value();
  settings.threads = static_cast<int>(options.threads.value_or(settings.processors.size()));
  settings.realtime_priority = static_cast<int>(options.realtime.value_or(0));
  if (options.spin_us) settings.spin = Nanoseconds(static_cast<std::int64_t>(*options.spin_us * 1e3));
  return settings;
}

void warn_of_threads(std::string_view command, int threads) {
  const int processors = parallel::available_threads();
  if (threads <= processors) return;
  print_error(
      "poise {}: warning: {} threads on {} processors: threads that wait for a processor make frames late, and "
      "each takes memory\n",
      command, threads, processors);
}

const char* executor_name(ExecutorKind kind) {
  switch (kind) {
    case ExecutorKind::Tbb:
      return "tbb";
    case ExecutorKind::Threads:
      return "threads";
    case ExecutorKind::Serial:
      return "serial";
    case ExecutorKind::Host:
      return "host";
  }
  return "serial";
}

}  // namespace poise::app
