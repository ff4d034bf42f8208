// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/types.h"

// A scene of another format on its way to a scene file of this project: bodies of solids, whose meshes are made when
// the file is written, so that a draft takes memory in proportion to what it was read from.
namespace poise::io {

enum class SolidKind : std::uint8_t {
  Sphere,     ///< half_m: radius
  Capsule,    ///< half_m: radius, half the straight part; along z
  Cylinder,   ///< half_m: radius, half the length; along z
  Ellipsoid,  ///< half_m: radii
  Box,        ///< half_m: half the edges
  Mesh,       ///< a mesh of the draft
};

/// A solid in the frame of its body.
struct DraftSolid {
  SolidKind kind = SolidKind::Sphere;
  Vec3 half_m = Vec3::Zero();
  std::size_t mesh = 0;  ///< of SolidKind::Mesh: index into SceneDraft::meshes
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
};

/// A mesh that solids share.
struct DraftMesh {
  std::string name;                                    ///< for messages
  std::filesystem::path file;                          ///< empty: `mesh`
  std::shared_ptr<const TriangleMesh> mesh = nullptr;  ///< may be that of others; not cleaned
  Mat3 linear = Mat3::Identity();  ///< from units of the file to metres: scales, and mirrors and shears if need be
};

struct DraftBody {
  std::string name;
  std::vector<DraftSolid> solids;  ///< a rigid union; empty: the half-space below the x-y plane of the body
  bool dynamic = false;            ///< else static
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
  double mass_kg = 0;  ///< 0: from volume and density
  double density_kgpm3 = 1000;
  double friction = 0;
  std::uint32_t group = 1;
  std::uint32_t collides_with = 0xffffffffU;
};

struct SceneDraft {
  std::string name;
  double dt_s = 1.0 / 60;
  Vec3 gravity_mps2{0, 0, -9.81};
  std::vector<DraftMesh> meshes;
  std::vector<DraftBody> bodies;
  std::vector<std::string> warnings;  ///< one line each: what was left out or is different
};

/// What a scene file says that the draft does not.
struct DraftSettings {
  std::uint64_t depth = 3;           ///< of sphere trees
  double shell_thickness_m = 0.001;  ///< of meshes that enclose nothing
  /// Vertices and triangles of all meshes together, each as often as it is read, and triangles that are written.
  /// Chosen: a minute or two.
  std::size_t most_read = 100'000'000, most_written = 20'000'000;
  /// Triangles of a mesh that is made of several solids, which is held whole, with its text. Chosen: 0.25 GB.
  std::size_t most_of_mesh = 2'000'000;
};

/// What was written.
struct WrittenDraft {
  std::size_t shapes = 0;
  std::size_t mesh_files = 0;
  std::vector<std::string> warnings;  ///< of the meshes
};

/// Volume of a solid that is not a mesh, m^3.
double volume_of(const DraftSolid& solid);

/// Saves the text of a mesh as a file, which is named from where the scene is named from.
using SaveMesh = std::function<Status(const std::filesystem::path&, const std::string&)>;

/// The text of the scene that write_draft writes to `file`; its meshes are handed to `save`. Refused likewise.
Result<std::string> draft_text(const SceneDraft& draft, const DraftSettings& settings,
                               const std::filesystem::path& file, const SaveMesh& save, WrittenDraft& written);

/// Writes the scene file, and beside it a folder STEM-meshes of the meshes that had to be made, if any. The scene file
/// is written last. Refused: a mesh that read_mesh refuses, more triangles to be written than most_written or most_read
/// to be read, a body of more than most_of_mesh, what cannot be written, a draft without bodies, what is no scene
/// (parse_scene): then no scene file is written, and files that were there before are as they were. Only of more than
/// 256 mesh files some may have been replaced when another one cannot be written.
Result<WrittenDraft> write_draft(const SceneDraft& draft, const DraftSettings& settings,
                                 const std::filesystem::path& file);

}  // namespace poise::io
