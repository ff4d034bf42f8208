// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/field_reader.h"
#include "scene/name_index.h"

namespace poise::io {

/// The text of a scene file. Refused with the file: a file that does not exist, is a pipe or a device, is empty or too
/// large.
Result<std::string> read_scene_text(const std::filesystem::path& file);
/// The same from a stream, read to its end; messages begin with `name`.
Result<std::string> read_scene_stream(std::istream& stream, const std::string& name);

/// The shapes and materials of a scene by name; none is added while it is in use.
struct SceneNames {
  explicit SceneNames(const Scene& scene) : shapes(scene.shapes), materials(scene.materials) {}
  NameIndex<SceneShape> shapes;
  NameIndex<SceneMaterial> materials;
};

/// Parse the parts of a scene file, each from its own JSON value. Problems are added to `problems`.
void parse_materials(const JsonValue& value, Problems& problems, Scene& scene);
void parse_shapes(const JsonValue& value, Problems& problems, Scene& scene);
void parse_bodies(const JsonValue& value, Problems& problems, const SceneNames& names, Scene& scene);
void parse_tray(const JsonValue& value, Problems& problems, const SceneNames& names, Scene& scene);
void parse_generators(const JsonValue& value, Problems& problems, const SceneNames& names, Scene& scene);
void parse_camera(const JsonValue& value, Problems& problems, Scene& scene);
void parse_scene_gaze(const JsonValue& value, Problems& problems, Scene& scene);
void parse_policy(const JsonValue& value, Problems& problems, scheduler::Policy& policy);

/// Finds a shape or material by the text in `value`; adds a problem with the nearest name if there is none.
void read_shape_name(const JsonValue& value, const std::string& path, Problems& problems, const SceneNames& names,
                     std::size_t& target);
void read_material_name(const ObjectReader& reader, const SceneNames& names, std::size_t& target);
[[nodiscard]] bool is_plane(const Scene& scene, std::size_t shape);

}  // namespace poise::io
