// SPDX-License-Identifier: MIT
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "assets/files/text_cursor.h"
#include "assets/mesh/face_list.h"
#include "assets/mesh/mesh_files.h"

namespace poise::geometry {
namespace {

/// A line that ends in a backslash continues in the next one, unless the backslash is in a comment. Joins such lines,
/// with each line end replaced by a blank, and adds the same number of line ends after them, so that line numbers stay
/// the same.
std::string joined_lines(std::string_view text, char line_end) {
  std::string joined;
  joined.reserve(text.size());
  std::size_t owed = 0;
  bool in_comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && !in_comment) {
      const std::size_t end = i + 1 + (text.substr(i + 1).starts_with("\r\n") ? 1U : 0U);
      if (end < text.size() && text[end] == line_end) {
        joined += ' ';
        ++owed;
        i = end;
        continue;
      }
    }
    joined += text[i];
    if (text[i] == '#') in_comment = true;
    if (text[i] == line_end) {
      joined.append(owed, line_end);
      owed = 0;
      in_comment = false;
    }
  }
  return joined;
}

/// A face as it was written. Its vertices may come later, so that it is made into triangles at the end.
struct Face {
  std::size_t end = 0;   ///< its corners are those up to here, from the face before
  std::size_t line = 0;  ///< for messages
};

/// What is read of a file.
struct Parsed {
  TriangleMesh mesh;
  std::vector<std::uint32_t> corners;
  std::vector<Face> faces;
};

std::string read_vertex(TextCursor& text, TriangleMesh& mesh) {
  Vec3& vertex = mesh.vertices_m.emplace_back();
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = text.next_word();
    if (!parse_finite(word, vertex[axis]))
      return fmt::format("{} of a vertex is '{}', must be a finite number", "xyz"[axis], shown_word(word));
  }
  return {};
}

/// A corner `vertex`, `vertex/texture`, `vertex//normal` or `vertex/texture/normal`, each counted from 1 on or, below
/// 0, back from the last one so far.
std::string read_corner(std::string_view word, std::size_t vertices, std::uint32_t& corner) {
  const std::string_view digits = word.substr(0, word.find('/'));
  std::int64_t number = 0;
  if (!parse_number(digits, number) || number == 0 || word.find_first_not_of("-+0123456789/") != std::string_view::npos)
    return fmt::format("a corner of a face is '{}', must be the number of a vertex, from 1 or below 0",
                       shown_word(word));
  const std::int64_t index = number > 0 ? number - 1 : number + static_cast<std::int64_t>(vertices);
  if (index < 0 || index >= std::numeric_limits<std::uint32_t>::max())
    return fmt::format("a face names vertex {} where there are {}, must exist", number, vertices);
  corner = static_cast<std::uint32_t>(index);
  return {};
}

std::string read_face(TextCursor& text, Parsed& parsed) {
  for (std::string_view word = text.next_word(); !word.empty(); word = text.next_word()) {
    std::string wrong = read_corner(word, parsed.mesh.vertices_m.size(), parsed.corners.emplace_back());
    if (!wrong.empty()) return wrong;
  }
  parsed.faces.push_back({parsed.corners.size(), text.number()});
  return {};
}

/// Cuts the faces into triangles.
Status add_faces(Parsed& parsed) {
  FaceList faces(parsed.mesh, 1);
  std::size_t begin = 0;
  for (const Face& face : parsed.faces) {
    const std::span<const std::uint32_t> corners = std::span(parsed.corners).subspan(begin, face.end - begin);
    begin = face.end;
    if (const std::string wrong = faces.add(corners); !wrong.empty())
      return bad_input(fmt::format("line {}: {}", face.line, wrong));
  }
  return Done{};
}

}  // namespace

Result<TriangleMesh> parse_obj(std::string_view whole) {
  const char line_end = line_end_of(whole);
  std::string joined;
  if (whole.find('\\') != std::string_view::npos) whole = joined = joined_lines(whole, line_end);
  TextCursor text(whole, true, line_end);
  Parsed parsed;
  while (text.next_line()) {
    const std::string_view word = text.next_word();
    std::string wrong;
    if (word == "v") wrong = read_vertex(text, parsed.mesh);
    if (word == "f" || word == "fo") wrong = read_face(text, parsed);
    if (!wrong.empty()) return bad_input(fmt::format("line {}: {}", text.number(), wrong));
  }
  if (parsed.mesh.vertices_m.size() > std::numeric_limits<std::uint32_t>::max())
    return bad_input("has more than 2^32 vertices");
  if (const Status added = add_faces(parsed); !added) return added.error();
  return std::move(parsed.mesh);
}

}  // namespace poise::geometry
