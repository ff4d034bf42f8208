// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>

#include "poise/result.h"
#include "scene/import/scene_draft.h"

namespace poise::io {

/// Things of a model that a scene of rigid bodies cannot have, by kind, each with how many there are and where the
/// first is.
class UnmodelledKinds {
 public:
  void add(const std::string& kind, const std::string& line);
  [[nodiscard]] bool empty() const { return kinds_.empty(); }
  /// `2 hinge joints (first at line 4), ...`; at most twenty kinds are named.
  [[nodiscard]] std::string text() const;

 private:
  struct Seen {
    std::size_t count = 0, order = 0;
    std::string line;
  };
  std::map<std::string, Seen> kinds_;
};

/// Reads a model of MuJoCo (MJCF) as docs/my-robots.md describes. `folder` is that of the model, for includes and
/// meshes; meshes are not read here. What is not modelled is refused with a list, or left out with `skip_unmodelled`,
/// when the list is a warning. Any thread. Refused with file, line, attribute and rule.
Result<SceneDraft> import_mjcf(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                               bool skip_unmodelled);

}  // namespace poise::io
