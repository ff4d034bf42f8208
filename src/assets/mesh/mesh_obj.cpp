// SPDX-License-Identifier: MIT
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include "assets/mesh/mesh_files.h"
#include "geometry/mesh/ear_clipping.h"

namespace poise::geometry {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view next_word(std::string_view& line) {
  const std::size_t begin = std::min(line.find_first_not_of(kBlanks), line.size());
  const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

bool parse_finite(std::string_view word, double& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size() && std::isfinite(value);
}

/// A line that ends in a backslash continues in the next one, which the loader does not support. Joins such lines, with
/// each line end replaced by a blank, and adds the same number of line ends after them, so that line numbers stay the
/// same.
std::string joined_lines(const std::string& text) {
  if (text.find('\\') == std::string::npos) return text;
  std::string joined;
  std::size_t owed = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool carriage = text[i] == '\\' && i + 2 < text.size() && text[i + 1] == '\r' && text[i + 2] == '\n';
    if (carriage || (text[i] == '\\' && i + 1 < text.size() && text[i + 1] == '\n')) {
      joined += ' ';
      ++owed;
      i += carriage ? 2 : 1;
      continue;
    }
    joined += text[i];
    if (text[i] == '\n') {
      joined.append(owed, '\n');
      owed = 0;
    }
  }
  return joined;
}

/// The loader reads a word that is not a number as 0, and its numbers may be wrong in the last digit, so the
/// coordinates are read here first. Returns what is wrong with one; empty if all are valid.
std::string read_coordinates(std::string_view text, std::vector<Vec3>& vertices) {
  std::size_t line_number = 0;
  while (!text.empty()) {
    ++line_number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (next_word(line) != "v") continue;
    Vec3& vertex = vertices.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = next_word(line);
      if (!parse_finite(word, vertex[axis])) {
        return fmt::format("line {}: {} of a vertex is '{}', must be a finite number", line_number, "xyz"[axis],
                           word.substr(0, 40));
      }
    }
  }
  return {};
}

}  // namespace

Result<TriangleMesh> parse_obj(const std::string& file_text) {
  const std::string text = joined_lines(file_text);
  TriangleMesh mesh;
  if (std::string wrong = read_coordinates(text, mesh.vertices_m); !wrong.empty()) return bad_input(std::move(wrong));
  tinyobj::ObjReaderConfig config;
  config.triangulate = false;
  config.vertex_color = false;
  tinyobj::ObjReader reader;
  if (!reader.ParseFromString(text, std::string(), config)) {
    std::string why = reader.Error();
    std::ranges::replace(why, '\n', ' ');
    return bad_input(fmt::format("not a valid OBJ: {}", why));
  }
  if (reader.GetAttrib().vertices.size() != 3 * mesh.vertices_m.size()) {
    return bad_input(fmt::format("not a valid OBJ: {} lines 'v', but {} vertices", mesh.vertices_m.size(),
                                 reader.GetAttrib().vertices.size() / 3));
  }
  std::size_t face_number = 0;
  std::vector<std::uint32_t> corners;
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    std::size_t first = 0;
    for (const auto corner_count : shape.mesh.num_face_vertices) {
      ++face_number;
      corners.clear();
      for (std::size_t i = 0; i < corner_count; ++i) {
        const int index = shape.mesh.indices[first + i].vertex_index;
        if (index < 0 || static_cast<std::size_t>(index) >= mesh.vertices_m.size()) {
          return bad_input(fmt::format("face {}: names vertex {} of {}, must exist", face_number, index + 1,
                                       mesh.vertices_m.size()));
        }
        corners.push_back(static_cast<std::uint32_t>(index));
      }
      first += corner_count;
      triangulate_polygon(mesh.vertices_m, corners, mesh.triangles);
    }
  }
  return mesh;
}

}  // namespace poise::geometry
