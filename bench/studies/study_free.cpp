// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include "app/files/output_files.h"
#include "app/files/scene_files.h"
#include "app/process/exit_codes.h"
#include "app/process/program_beside.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "assets/files/text_file.h"
#include "parallel/interrupt.h"
#include "scene/result_file.h"
#include "studies/callgrind_output.h"
#include "studies/child_command.h"
#include "studies/study_timing.h"

namespace poise::app {
namespace {

/// A folder for profiles and outputs that the destructor removes.
class Scratch {
 public:
  static Result<std::unique_ptr<Scratch>> create() {
    std::error_code failure;
    std::string name = (std::filesystem::temp_directory_path(failure) / "poise-XXXXXX").string();
    if (failure || ::mkdtemp(name.data()) == nullptr)
      return Error{ErrorKind::OutputFailed, "no temporary folder can be made"};
    return std::unique_ptr<Scratch>(new Scratch(name));
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }

 private:
  explicit Scratch(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
};

using Words = std::vector<std::string>;

constexpr std::uint64_t kMostText = 1ULL << 28U;

/// An optional part of a step.
struct Feature {
  std::string name, scene;
  Words off, on;
  Words functions;  ///< parts of the names of functions that only this feature has; empty: its code is inside kernels
                    ///< that all scenes use
};

std::vector<Feature> features(const Scratch& scratch, const std::string& frictionless) {
  return {
      {"friction", "jacks", {frictionless}, {}, {}},
      {"polygons",
       "pile",
       {},
       {"--max-level", "polygons"},
       {"_polygons", "polygon_units", "triangle_pair", "PolygonSums"}},
      {"backtracking",
       "jacks",
       {},
       {"--backtracking"},
       {"begin_swept", "sweep_if_fast", "send_swept", "answer_swept", "swept_slack_m", "collision::advance"}},
      {"sleeping", "jacks", {}, {"--sleeping"}, {"wake_stirred", "wake_touched", "fall_asleep"}},
      {"recording", "jacks", {}, {"--record", scratch.file("record")}, {"DecisionLog", "begin_log"}},
      {"tracing", "jacks", {}, {"--trace", scratch.file("trace.json")}, {"trace_frame"}},
      {"reference", "jacks", {}, {"--reference", "every=1"}, {"simulation::refer(", "simulation::remember("}},
  };
}

/// Number of instructions inside World::step in one run of `poise`.
Result<Counted> count(const Words& options, const Scratch& scratch, const parallel::Interrupt& interrupt) {
  const Result<std::filesystem::path> program = program_beside("poise");
  if (!program) return program.error();
  const std::string profile = scratch.file("profile");
  Words words{"valgrind",
              "--tool=callgrind",
              "--quiet",
              "--callgrind-out-file=" + profile,
              "--toggle-collect=poise::World::step*",
              program.value().string(),
              "run"};
  words.insert(words.end(), options.begin(), options.end());
  const Result<ChildResult> done = run_program(std::move(words), interrupt);
  if (!done) return done.error();
  if (interrupt.asked()) return stopped_error();
  if (done.value().exit_code != 0)
    return bad_input(
        fmt::format("poise run {} ended with {} under valgrind", fmt::join(options, " "), done.value().exit_code));
  const Result<std::string> text = geometry::read_text_file(profile, kMostText);
  if (!text) return text.error();
  return read_callgrind(text.value());
}

/// The shipped jacks scene without friction.
Result<std::string> write_frictionless(const Scratch& scratch) {
  const Result<std::filesystem::path> file = find_scene("jacks");
  if (!file) return file.error();
  Result<std::string> text = geometry::read_text_file(file.value(), kMostText);
  if (!text) return text.error();
  const std::string with = "\"friction\": 0.5";
  const std::size_t at = text.value().find(with);
  if (at == std::string::npos) return bad_input("jacks.json: has no friction of 0.5 to take away");
  text.value().replace(at, with.size(), "\"friction\": 0");
  const std::string path = scratch.file("frictionless.json");
  const Status written = io::write_file(path, text.value());
  if (!written) return written.error();
  return path;
}

bool known_option(const std::string& option, const parallel::Interrupt& interrupt) {
  const Result<ChildResult> help = run_child({"run", "--help"}, interrupt);
  return help && help.value().out.find(option) != std::string::npos;
}

Result<io::FreeRow> row_of(const Feature& feature, std::uint64_t bodies, std::uint64_t frames, const Scratch& scratch,
                           const parallel::Interrupt& interrupt) {
  io::FreeRow row;
  row.feature = feature.name;
  row.absent = !feature.on.empty() && !known_option(feature.on.front(), interrupt);
  if (row.absent) return row;
  const auto options = [&](const Words& own) {
    // A scene given by the user replaces the shipped one.
    const bool other_scene = own.size() == 1 && own.front().front() != '-';
    Words words{other_scene ? own.front() : feature.scene,
                "--frames",
                std::to_string(frames),
                "--clock",
                "work",
                "--budget-work",
                "2000",
                "--threads",
                "1",
                "--executor",
                "serial",
                "--quiet"};
    words.insert(words.end(), {"--bodies", std::to_string(bodies)});
    if (!other_scene) words.insert(words.end(), own.begin(), own.end());
    return words;
  };
  // Builds and caches the trees that the scene needs: under valgrind that would take minutes.
  Words plain = options({});
  plain[2] = "1";
  const Result<ChildResult> warm = run_child(
      [&] {
        Words words{"run"};
        words.insert(words.end(), plain.begin(), plain.end());
        return words;
      }(),
      interrupt);
  if (!warm) return warm.error();
  if (interrupt.asked()) return stopped_error();
  const Result<Counted> off = count(options(feature.off), scratch, interrupt);
  if (!off) return off.error();
  const Result<Counted> on = count(options(feature.on), scratch, interrupt);
  if (!on) return on.error();
  row.off_options = fmt::format("{}", fmt::join(feature.off, " "));
  row.on_options = fmt::format("{}", fmt::join(feature.on, " "));
  row.off_instructions = static_cast<double>(off.value().instructions) / static_cast<double>(frames);
  row.on_instructions = static_cast<double>(on.value().instructions) / static_cast<double>(frames);
  row.inside_kernels = feature.functions.empty();
  row.called_off = with_any(off.value().functions, feature.functions);
  row.functions_on = with_any(on.value().functions, feature.functions).size();
  return row;
}

}  // namespace

int study_free(const StudyTimingOptions& o) {
  const Status sound = check_timing_options(o);
  if (!sound) return refuse("study free", kExitBadUsage, sound.error().message);
  const Status writable = can_write({o.json, o.markdown});
  if (!writable) return refuse("study free", exit_code_of(writable.error()), writable.error().message);
  const parallel::Interrupt interrupt;
  const Result<ChildResult> valgrind = run_program({"valgrind", "--version"}, interrupt);
  if (!valgrind || valgrind.value().exit_code != 0)
    return refuse("study free", kExitBadInput, "needs valgrind, which is not installed");
  const Result<std::unique_ptr<Scratch>> scratch = Scratch::create();
  if (!scratch) return refuse("study free", exit_code_of(scratch.error()), scratch.error().message);
  const Result<std::string> frictionless = write_frictionless(*scratch.value());
  if (!frictionless) return refuse("study free", exit_code_of(frictionless.error()), frictionless.error().message);
  io::FreeDocument document;
  document.counted_by =
      valgrind.value().out.substr(0, valgrind.value().out.find('\n')) + " callgrind, inside World::step";
  document.frames = o.frames.value_or(20);
  const std::vector<Feature> all = features(*scratch.value(), frictionless.value());
  Progress progress(!o.quiet);
  for (std::size_t i = 0; i < all.size(); ++i) {
    progress.share(all[i].name, static_cast<double>(i) / static_cast<double>(all.size()));
    const Result<io::FreeRow> row =
        row_of(all[i], o.bodies.empty() ? 40 : o.bodies.front(), document.frames, *scratch.value(), interrupt);
    if (!row) return refuse("study free", exit_code_of(row.error()), row.error().message);
    document.rows.push_back(row.value());
  }
  progress.end();
  document.by = measured_by(o, 1);
  const int written =
      write_timing(o, "free", io::free_json(document), io::free_markdown(document), io::free_charts(document));
  if (written != kExitDone) return written;
  for (const io::FreeRow& row : document.rows) {
    if (row.ok()) continue;
    return refuse(
        "study free", kExitRequirementFailed,
        row.called_off.empty()
            ? fmt::format("{}: none of its functions was seen when it is on, so nothing is shown", row.feature)
            : fmt::format("{}: is off, and {} is called", row.feature, row.called_off.front()));
  }
  return kExitDone;
}

}  // namespace poise::app
