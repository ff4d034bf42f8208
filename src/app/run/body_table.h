// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "poise/result.h"
#include "poise/scene/scene.h"
#include "scene/result_file.h"

namespace poise::app {

/// The table of bodies beside a table of states: `states.bodies.csv` for `states.csv`. Empty for an empty path, and
/// for one that is a pipe or a device.
std::string body_table_of(const std::string& states);

/// Writes it. Invariant: has a row for each body that add() found, ascending by number.
class BodyTable {
 public:
  /// For an empty path it does nothing. Refused: a file that cannot be written.
  static Result<BodyTable> open(const std::string& states);
  /// Takes the bodies that were not there before.
  Status add(const Scene& scene, const SceneRun& run);
  /// Writes the file; it is not there before.
  Status finish();

 private:
  std::optional<io::AtomicFile> file_;
  std::uint64_t next_number_ = 0;
  std::string text_;
};

}  // namespace poise::app
