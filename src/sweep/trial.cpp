// SPDX-License-Identifier: MIT
#include "sweep/trial.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <set>
#include <variant>

#include "assets/files/text_file.h"
#include "assets/json/json_document.h"

namespace poise::sweep {
namespace {

/// Largest file that a scene or setting may name. Chosen far above any mesh.
constexpr std::uint64_t kMostNamedFileBytes = std::uint64_t{1} << 32U;

Result<std::string> file_hash(const std::filesystem::path& file) {
  const Result<std::string> bytes = geometry::read_text_file(file, kMostNamedFileBytes);
  if (!bytes) return bytes.error();
  return content_hash(bytes.value());
}

/// The files that a scene names, as it names them.
std::set<std::filesystem::path> files_of(const Scene& scene) {
  std::set<std::filesystem::path> files;
  for (const SceneShape& shape : scene.shapes) {
    if (const auto* mesh = std::get_if<MeshSource>(&shape.source)) files.insert(mesh->file);
    if (const auto* tree = std::get_if<TreeSource>(&shape.source)) {
      files.insert(tree->file);
      if (!tree->mesh.empty()) files.insert(tree->mesh);
    }
  }
  if (scene.gaze && !scene.gaze->file.empty()) files.insert(scene.gaze->file);
  return files;
}

std::string label_of(const SweepSpec& spec, const Trial& trial) {
  std::string text = trial.scene;
  for (const Axis& axis : spec.axes) text += fmt::format(", {}={}", axis.name, trial.value_of(axis.name));
  if (spec.repeats > 1) text += fmt::format(", repeat {}", trial.repeat);
  return io::printable(text);
}

std::uint64_t threads_of(const Trial& trial) {
  const std::string_view text = trial.value_of("threads");
  std::uint64_t threads = 0;
  std::from_chars(text.data(), text.data() + text.size(), threads);
  return threads;
}

}  // namespace

std::string content_hash(std::string_view bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::string_view Trial::value_of(std::string_view name) const {
  const auto found = std::ranges::find(settings, name, &Setting::name);
  return found == settings.end() ? std::string_view() : std::string_view(found->text);
}

Result<std::string> scene_hash(std::string_view text, const Scene& scene) {
  std::string all = "poise.scene\n" + content_hash(text) + "\n";
  for (const std::filesystem::path& file : files_of(scene)) {
    const Result<std::string> hash = file_hash(file.is_absolute() ? file : scene.base / file);
    if (!hash) return bad_input(scene.source + ": " + hash.error().message);
    all += file.generic_string() + "\n" + hash.value() + "\n";
  }
  return content_hash(all);
}

Result<std::string> trial_key(const Trial& trial, std::string_view build) {
  // Sorted by name, so that the order of a specification does not matter.
  std::map<std::string, std::string> settings;
  for (const Setting& setting : trial.settings) {
    settings[setting.name] = setting.text;
    const std::string file = file_of(setting, trial.base);
    if (file.empty()) continue;
    const Result<std::string> hash = file_hash(file);
    if (!hash) return hash.error();
    settings[setting.name] = "content " + hash.value();
  }
  std::string all = fmt::format("poise.trial/1\n{}\nscene {}\n", build, trial.scene_hash);
  // With its length before it, no text looks like two others.
  for (const auto& [name, text] : settings) all += fmt::format("{}:{}={}:{}\n", name.size(), name, text.size(), text);
  all += fmt::format("repeat {}\n", trial.repeat);
  if (trial.timed) all += fmt::format("cores {}\n", trial.cores);
  return content_hash(all);
}

Result<std::vector<Trial>> expand(const SweepSpec& spec, const std::vector<SceneFile>& scenes, std::string_view build) {
  std::vector<Trial> trials;
  std::set<std::string> keys;
  for (const SceneFile& scene : scenes) {
    std::vector<std::size_t> at(spec.axes.size(), 0);
    for (bool more = true; more;) {
      Trial trial;
      trial.scene = scene.name;
      trial.scene_file = scene.file;
      trial.scene_hash = scene.hash;
      trial.settings = spec.settings;
      for (std::size_t i = 0; i < at.size(); ++i) trial.settings.push_back(spec.axes[i].values[at[i]]);
      trial.timed = trial.value_of("clock") != "work";
      trial.cores = spec.cores.value_or(std::max<std::uint64_t>(1, threads_of(trial)));
      trial.time_limit_s = spec.time_limit_s;
      trial.base = spec.base;
      for (trial.repeat = 1; trial.repeat <= spec.repeats; ++trial.repeat) {
        Result<std::string> key = trial_key(trial, build);
        if (!key) return key.error();
        trial.key = std::move(key).value();
        trial.label = label_of(spec, trial);
        if (!keys.insert(trial.key).second)
          return bad_input(
              fmt::format("{}: two trials would be the same run: {}; scenes or policies have the same content",
                          spec.source, trial.label));
        trials.push_back(trial);
      }
      // The next combination; the last axis varies fastest.
      std::size_t axis = at.size();
      while (axis > 0 && ++at[axis - 1] == spec.axes[axis - 1].values.size()) at[--axis] = 0;
      more = axis > 0;
    }
  }
  return trials;
}

std::vector<std::string> trial_words(const Trial& trial, const std::string& json) {
  std::vector<std::string> words{"run", trial.scene_file};
  for (const Setting& setting : trial.settings) add_words(setting, trial.base, words);
  words.insert(words.end(), {"--no-time-priors", "--quiet", "--json", json});
  return words;
}

}  // namespace poise::sweep
