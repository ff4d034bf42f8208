// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/field_reader.h"

namespace poise::io {

/// The text of a scene file, as read_scene reads it. Refused with the file: one that is not there, a pipe or a device,
/// empty or too large.
Result<std::string> read_scene_text(const std::filesystem::path& file);
/// The same from a stream, read to its end; `name` stands in the messages.
Result<std::string> read_scene_stream(std::istream& stream, const std::string& name);

/// The parts of a scene file, each from its own JSON value. Problems are noted, never thrown.
void parse_materials(const JsonValue& value, Problems& problems, Scene& scene);
void parse_shapes(const JsonValue& value, Problems& problems, Scene& scene);
void parse_bodies(const JsonValue& value, Problems& problems, Scene& scene);
void parse_tray(const JsonValue& value, Problems& problems, Scene& scene);
void parse_generators(const JsonValue& value, Problems& problems, Scene& scene);
void parse_camera(const JsonValue& value, Problems& problems, Scene& scene);
void parse_policy(const JsonValue& value, Problems& problems, Scene& scene);

/// Looks a shape or material up by the text in `value`; notes a problem with the nearest name if there is none.
void read_shape_name(const JsonValue& value, const std::string& path, Problems& problems, const Scene& scene,
                     std::size_t& target);
void read_material_name(const ObjectReader& reader, const Scene& scene, std::size_t& target);
[[nodiscard]] bool is_plane(const Scene& scene, std::size_t shape);

}  // namespace poise::io
