// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "poise/scene/scene.h"
#include "sweep/run_settings.h"
#include "sweep/sweep_spec.h"

namespace poise::sweep {

/// A scene of a sweep, found and read.
struct SceneFile {
  std::string name;  ///< as the specification has it
  std::string file;  ///< absolute, for the command line
  std::string hash;  ///< of its content, scene_hash
};

/// One run of a sweep.
struct Trial {
  std::string key;    ///< 32 hexadecimal digits: the hash of all that its result depends on
  std::string label;  ///< for a person: scene and what tells it from other trials, `jacks, bodies=250, repeat 2`
  std::string scene;
  std::string scene_file;
  std::string scene_hash;
  std::vector<Setting> settings;  ///< those of all trials, then those of the axes in their order
  std::uint64_t repeat = 1;       ///< from 1
  std::uint64_t cores = 1;        ///< that it needs
  bool timed = true;              ///< it runs by the wall clock, so nothing else may run on its cores
  double time_limit_s = 3600;
  std::string base;  ///< folder that the files of its settings are relative to

  /// The value of a setting as text, empty if it has none of this name.
  [[nodiscard]] std::string_view value_of(std::string_view name) const;
};

/// 32 hexadecimal digits (XXH3, 128 bits).
std::string content_hash(std::string_view bytes);

/// Hash of the text of a scene and of each file that it names (meshes, trees, a recorded gaze). Refused: a file that
/// cannot be read.
Result<std::string> scene_hash(std::string_view text, const Scene& scene);

/// Hash of all that the result of a trial depends on: `build` (version, commit, compiler, flags), the scene, its
/// settings in any order, the content of the files that they name, the repeat, and for a timed trial its cores.
/// Refused: a file that cannot be read.
Result<std::string> trial_key(const Trial& trial, std::string_view build);

/// Every combination of scenes, values of the axes, and repeats: scenes vary slowest, then the axes in their order,
/// repeats fastest. `scenes` are those of the specification, in its order. Refused: a file of a setting that cannot be
/// read; two trials with the same key, which are of scenes with the same content.
Result<std::vector<Trial>> expand(const SweepSpec& spec, const std::vector<SceneFile>& scenes, std::string_view build);

/// The words after `poise` that run a trial and write its result to `json`. What runs before have learned of times is
/// not used, so that no trial depends on another.
std::vector<std::string> trial_words(const Trial& trial, const std::string& json);

}  // namespace poise::sweep
