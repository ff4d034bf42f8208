// SPDX-License-Identifier: MIT
#include "app/sweep/sweep_plan.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <set>
#include <system_error>

#include "app/files/scene_files.h"
#include "app/files/scene_input.h"
#include "app/run/run_options.h"
#include "assets/files/text_file.h"
#include "assets/json/json_document.h"
#include "scene/made_by.h"
#include "scene/scene_parse.h"

namespace poise::app {
namespace {

namespace fs = std::filesystem;

/// So many refusals of combinations are told; the same mistake makes thousands.
constexpr std::size_t kToldCombinations = 10;
constexpr std::uint64_t kMostProgramBytes = std::uint64_t{1} << 31U;

/// What `poise run` makes of these words; the message is the one that it would print.
Result<RunOptions> run_options_of(std::vector<std::string> words) {
  RunOptions options;
  CLI::App app;
  add_run_options(app, options);
  std::ranges::reverse(words);
  try {
    app.parse(words);
  } catch (const CLI::ParseError& refused) {
    return bad_input(refused.what());
  }
  return options;
}

/// Each value alone, so that a refusal names its place in the file.
void check_value(const sweep::SweepSpec& spec, const std::string& path, const sweep::Setting& setting,
                 std::vector<std::string>& errors) {
  const std::string file = sweep::file_of(setting, spec.base);
  std::error_code failure;
  if (!file.empty() && !fs::exists(file, failure)) {
    errors.push_back(
        fmt::format("{}: {} = \"{}\", {} cannot be read: no such file", spec.source, path, setting.text, file));
    return;
  }
  std::vector<std::string> words{"scene"};
  sweep::add_words(setting, spec.base, words);
  const Result<RunOptions> options = run_options_of(std::move(words));
  Status checked = Done{};
  if (!options) checked = options.error();
  // Weights are read later than other values; alone they contradict nothing.
  if (options && !options.value().weights.empty()) checked = check_run_options(options.value());
  if (!checked) errors.push_back(fmt::format("{}: {}: {}", spec.source, path, checked.error().message));
}

void check_values(const sweep::SweepSpec& spec, std::vector<std::string>& errors) {
  for (const sweep::Setting& setting : spec.settings)
    check_value(spec, io::member_path("settings", setting.name), setting, errors);
  for (const sweep::Axis& axis : spec.axes) {
    for (std::size_t i = 0; i < axis.values.size(); ++i)
      check_value(spec, io::item_path(io::member_path("axes", axis.name), i), axis.values[i], errors);
  }
}

struct ReadScene {
  sweep::SceneFile file;
  Scene scene;
};

Result<ReadScene> read_scene_of(const sweep::SweepSpec& spec, const std::string& name) {
  const bool shipped = name.find('/') == std::string::npos && name.find('.') == std::string::npos;
  const std::string argument = shipped ? name : (fs::path(spec.base) / name).string();
  const Result<fs::path> found = find_scene(argument);
  if (!found) return found.error();
  std::error_code failure;
  const fs::path file = fs::absolute(found.value(), failure).lexically_normal();
  const Result<std::string> text = io::read_scene_text(file);
  if (!text) return text.error();
  std::vector<std::string> errors;
  Result<Scene> scene = parse_scene(text.value(), file.string(), file.parent_path(), &errors);
  if (!scene) return scene.error();
  Result<std::string> hash = sweep::scene_hash(text.value(), scene.value());
  if (!hash) return hash.error();
  return ReadScene{{name, file.string(), hash.value()}, std::move(scene).value()};
}

/// The settings of a trial together, as far as `poise run` tells before it loads anything.
Status check_trial(const sweep::Trial& trial, const Scene& scene) {
  std::vector<std::string> words{trial.scene_file};
  for (const sweep::Setting& setting : trial.settings) sweep::add_words(setting, trial.base, words);
  Result<RunOptions> options = run_options_of(std::move(words));
  if (!options) return options.error();
  const Status sound = check_run_options(options.value());
  if (!sound) return sound;
  if (options.value().bodies && scene.generators.empty()) return bad_input("bodies: the scene has no generators");
  if (!options.value().gaze.empty() && !scene.camera) return bad_input("gaze: the scene has no camera");
  return Done{};
}

void check_trials(const SweepPlan& plan, const std::map<std::string, Scene>& scenes, std::vector<std::string>& errors) {
  std::set<std::string> told;
  for (const sweep::Trial& trial : plan.trials) {
    if (trial.repeat != 1) continue;
    const Status checked = check_trial(trial, scenes.at(trial.scene));
    if (checked) continue;
    // The same contradiction of many trials is told once.
    if (!told.insert(checked.error().message).second) continue;
    errors.push_back(fmt::format("{}: {}: {}", plan.spec.source, trial.label, checked.error().message));
    if (told.size() >= kToldCombinations) return;
  }
}

double number_in(const sweep::Trial& trial, std::string_view name, double otherwise) {
  const std::string_view text = trial.value_of(name);
  double value = otherwise;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

}  // namespace

Result<std::string> program_identity() {
  const io::BuildFacts build = io::this_build();
  std::string identity = fmt::format("{} {} {} {}", build.version, build.commit, build.compiler, build.flags);
  const bool known = build.commit.find('+') == std::string::npos && build.commit != "unknown";
  if (known) return identity;
  const Result<std::string> bytes = geometry::read_text_file("/proc/self/exe", kMostProgramBytes);
  if (!bytes) return bytes.error();
  return identity + " " + sweep::content_hash(bytes.value());
}

Result<SweepPlan> plan_sweep(const std::string& file, std::vector<std::string>& errors) {
  Result<sweep::SweepSpec> spec = sweep::read_spec(file, errors);
  if (!spec) return spec.error();
  SweepPlan plan{std::move(spec).value(), {}, {}};
  // Tasks on other machines may begin in another folder.
  std::error_code failure;
  plan.spec.base = fs::absolute(plan.spec.base, failure).lexically_normal().string();
  check_values(plan.spec, errors);
  std::vector<sweep::SceneFile> files;
  std::map<std::string, Scene> scenes;
  for (std::size_t i = 0; i < plan.spec.scenes.size(); ++i) {
    Result<ReadScene> read = read_scene_of(plan.spec, plan.spec.scenes[i]);
    if (!read) {
      errors.push_back(fmt::format("{}: {}: {}", plan.spec.source, io::item_path("scenes", i), read.error().message));
      continue;
    }
    const Scene& scene = read.value().scene;
    plan.scenes[read.value().file.name] = {static_cast<double>(scene.frames),
                                           scene.deadline_ms.value_or(1000 * scene.dt_s)};
    files.push_back(read.value().file);
    scenes.emplace(read.value().file.name, std::move(read.value().scene));
  }
  if (!errors.empty()) return bad_input(errors.front());
  const Result<std::string> identity = program_identity();
  if (!identity) return identity.error();
  Result<std::vector<sweep::Trial>> trials = sweep::expand(plan.spec, files, identity.value());
  if (!trials) {
    errors.push_back(trials.error().message);
    return trials.error();
  }
  plan.trials = std::move(trials).value();
  check_trials(plan, scenes, errors);
  if (!errors.empty()) return bad_input(errors.front());
  return plan;
}

Status check_unchanged(const sweep::Trial& trial, const std::string& identity) {
  const Result<std::string> text = io::read_scene_text(trial.scene_file);
  if (!text) return text.error();
  const fs::path folder = fs::path(trial.scene_file).parent_path();
  const Result<Scene> scene = parse_scene(text.value(), trial.scene_file, folder, nullptr);
  if (!scene) return scene.error();
  const Result<std::string> hash = sweep::scene_hash(text.value(), scene.value());
  if (!hash) return hash.error();
  sweep::Trial now = trial;
  now.scene_hash = hash.value();
  const Result<std::string> key = sweep::trial_key(now, identity);
  if (!key) return key.error();
  if (key.value() == trial.key) return Done{};
  if (now.scene_hash != trial.scene_hash)
    return bad_input(trial.scene_file + ": has changed since the trial was submitted");
  return bad_input("this program or a file of the settings has changed since the trial was submitted");
}

TimeEstimate estimate_time(const SweepPlan& plan, const sweep::TrialStore& store,
                           const std::vector<sweep::Trial>& pending) {
  struct Mean {
    double sum = 0;
    std::size_t count = 0;
  };
  std::map<std::string, Mean> by_scene;
  Mean all;
  for (const sweep::Trial& trial : plan.trials) {
    const sweep::Outcome outcome = store.outcome_of(trial);
    if (outcome.state == sweep::TrialState::Pending) continue;
    for (Mean* mean : {&by_scene[trial.scene], &all}) {
      mean->sum += outcome.seconds;
      ++mean->count;
    }
  }
  TimeEstimate estimate{0, {}, true};
  bool from_deadlines = false;
  for (const sweep::Trial& trial : pending) {
    const auto scene = by_scene.find(trial.scene);
    const Mean& mean = scene != by_scene.end() ? scene->second : all;
    if (mean.count > 0) {
      estimate.seconds += mean.sum / static_cast<double>(mean.count);
    } else if (trial.timed) {
      const SweepPlan::SceneTimes& times = plan.scenes.at(trial.scene);
      const double frames = number_in(trial, "frames", times.frames) + number_in(trial, "warmup", 0);
      estimate.seconds += 1e-3 * frames * number_in(trial, "deadline_ms", times.deadline_ms);
      from_deadlines = true;
    } else {
      estimate.known = false;
    }
  }
  estimate.basis = from_deadlines ? "as if each frame took its deadline, without loading"
                                  : fmt::format("from {} trials that have run", all.count);
  return estimate;
}

}  // namespace poise::app
