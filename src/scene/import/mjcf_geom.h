// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "poise/result.h"
#include "scene/import/mjcf_import.h"
#include "scene/import/mjcf_values.h"
#include "scene/import/scene_draft.h"

namespace poise::io {

/// What <compiler> and <asset> say to all bodies.
struct MjcfSettings {
  MjcfAngles angles;
  std::filesystem::path folder;  ///< of the model
  std::filesystem::path mesh_folder;
  bool file_names_only = false;                            ///< strippath
  bool ignore_inertial = false;                            ///< inertiafromgeom="true"
  std::map<std::string, std::size_t, std::less<>> meshes;  ///< by name: index into SceneDraft::meshes
};

/// A geom of a body.
struct MjcfGeom {
  DraftSolid solid;    ///< its pose is in the frame of the element that it is in
  bool plane = false;  ///< the half-space below its x-y plane; no solid
  std::uint64_t contype = 1, conaffinity = 1;
  double friction = 1;
  double mass_kg = -1;  ///< < 0: not given
  double density_kgpm3 = 1000;
  std::string name;
  [[nodiscard]] bool collides() const { return contype != 0 || conaffinity != 0; }
  /// Its mass where that is known without reading a mesh, else < 0.
  [[nodiscard]] double known_mass_kg() const;
};

/// Reads a <geom>. False: it is of a kind that is not modelled, which `unmodelled` tells. Refused: sizes and numbers
/// out of range, meshes that do not exist.
Result<bool> read_mjcf_geom(const MjcfView& view, const MjcfSettings& settings, UnmodelledKinds& unmodelled,
                            MjcfGeom& geom);

/// Reads a <mesh> of <asset>. Refused: one without file and vertices, faces of vertices that do not exist, a name
/// twice.
Status read_mjcf_mesh(const MjcfView& view, MjcfSettings& settings, UnmodelledKinds& unmodelled, SceneDraft& draft);

}  // namespace poise::io
