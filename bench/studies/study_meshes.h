// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "poise/result.h"

namespace poise::app {

struct StudyMesh {
  std::string name;  ///< for tables
  std::filesystem::path file;
};

/// The meshes of the docs: those shipped with the scenes, and files of the Debian packages libsimbody-dev and
/// assimp-testmodels. Missing ones are listed in `missing` instead.
std::vector<StudyMesh> default_study_meshes(std::vector<std::string>& missing);

/// Files given by the user, named by the last two parts of their paths.
std::vector<StudyMesh> named_study_meshes(const std::vector<std::string>& files);

/// A folder of meshes of one surface with 1,000 to `most` triangles, in steps of about the square root of ten. The
/// destructor removes it.
class ScalingMeshes {
 public:
  /// Refused: no temporary folder, or no space in it.
  static Result<ScalingMeshes> make(std::uint64_t most);
  ScalingMeshes(ScalingMeshes&& other) noexcept;
  ScalingMeshes& operator=(ScalingMeshes&& other) = delete;
  ~ScalingMeshes();
  [[nodiscard]] const std::vector<StudyMesh>& meshes() const { return meshes_; }

 private:
  ScalingMeshes() = default;
  std::filesystem::path folder_;  ///< empty: nothing to remove
  std::vector<StudyMesh> meshes_;
};

}  // namespace poise::app
