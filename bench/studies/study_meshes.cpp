// SPDX-License-Identifier: MIT
#include "studies/study_meshes.h"

#include <stdlib.h>

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <system_error>
#include <utility>

#include "app/files/scene_files.h"
#include "geometry/mesh/bumpy_ball.h"
#include "geometry/mesh/procedural.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

constexpr const char* kUr10 = "/usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry/";
constexpr const char* kAtlas = "/usr/share/doc/simbody/examples/src/TaskSpaceControl-Atlas/geometry/";
constexpr const char* kAssimp = "/usr/share/assimp/models/";

std::vector<StudyMesh> wanted_meshes() {
  std::vector<StudyMesh> meshes;
  const std::vector<std::filesystem::path> scenes = shipped_scenes();
  const std::filesystem::path shipped =
      scenes.empty() ? std::filesystem::path("meshes") : scenes.front().parent_path() / "meshes";
  for (const char* name : {"jack", "torus", "slab", "l", "bowl"})
    meshes.push_back({fmt::format("scenes/meshes/{}.obj", name), shipped / (std::string(name) + ".obj")});
  for (const char* name : {"Base", "Shoulder", "UpperArm", "Forearm", "Wrist1", "Wrist2", "Wrist3"}) {
    meshes.push_back({fmt::format("libsimbody-dev, UR10 {}.obj", name), fmt::format("{}{}.obj", kUr10, name)});
  }
  for (const char* name : {"mtorso", "l_talus", "l_uglut"}) {
    meshes.push_back({fmt::format("libsimbody-dev, Atlas {}.stl", name), fmt::format("{}{}.stl", kAtlas, name)});
  }
  meshes.push_back({"assimp-testmodels, empty_mat.obj", fmt::format("{}OBJ/empty_mat.obj", kAssimp)});
  return meshes;
}

}  // namespace

std::vector<StudyMesh> default_study_meshes(std::vector<std::string>& missing) {
  std::vector<StudyMesh> there;
  for (StudyMesh& mesh : wanted_meshes()) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(mesh.file, ignored)) {
      there.push_back(std::move(mesh));
    } else {
      missing.push_back(mesh.name);
    }
  }
  return there;
}

std::vector<StudyMesh> named_study_meshes(const std::vector<std::string>& files) {
  std::vector<StudyMesh> meshes;
  for (const std::filesystem::path path : files) {
    const std::filesystem::path folder = path.parent_path().filename();
    meshes.push_back({(folder / path.filename()).string(), path});
  }
  return meshes;
}

Result<ScalingMeshes> ScalingMeshes::make(std::uint64_t most) {
  ScalingMeshes made;
  std::error_code failure;
  std::string folder = (std::filesystem::temp_directory_path(failure) / "poise-study-XXXXXX").string();
  if (failure || ::mkdtemp(folder.data()) == nullptr) {
    return Error{ErrorKind::OutputFailed, fmt::format("{}: no folder can be made: {}", folder, std::strerror(errno))};
  }
  made.folder_ = folder;
  for (double asked = 1000; asked <= static_cast<double>(most) * 1.001; asked *= std::sqrt(10.0)) {
    const Result<TriangleMesh> mesh = geometry::bumpy_ball(static_cast<std::size_t>(asked));
    if (!mesh) return mesh.error();
    const std::size_t triangles = mesh.value().triangles.size();
    const std::filesystem::path file = made.folder_ / fmt::format("bumpy-{}.obj", triangles);
    const Status written =
        io::write_file(file, geometry::obj_text(mesh.value(), "made by: poise study trees --scaling"));
    if (!written) return written.error();
    made.meshes_.push_back({fmt::format("bumpy ball, {} triangles", triangles), file});
  }
  return made;
}

ScalingMeshes::ScalingMeshes(ScalingMeshes&& other) noexcept
    : folder_(std::exchange(other.folder_, {})), meshes_(std::move(other.meshes_)) {}

ScalingMeshes::~ScalingMeshes() {
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

}  // namespace poise::app
