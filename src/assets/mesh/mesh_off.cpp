// SPDX-License-Identifier: MIT
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "assets/files/text_cursor.h"
#include "assets/mesh/face_list.h"
#include "assets/mesh/mesh_files.h"

namespace poise::geometry {
namespace {

/// Numbers of vertices, faces and edges; the last is of no use.
constexpr std::array kCounted{"vertices", "faces", "edges"};
constexpr std::size_t kCounts = kCounted.size();
/// A vertex takes `0 0 0` at least, and a face `1 0`, each with a line end that the last may lack.
constexpr std::size_t kVertexBytes = 6;
constexpr std::size_t kFaceBytes = 4;

std::string line_of(const TextCursor& text) { return fmt::format("line {}: ", text.number()); }

/// Why `count` entries cannot be in the rest of the file; empty if they can.
std::string too_many(const TextCursor& text, std::uint64_t count, const char* what, std::size_t least_bytes) {
  if (count <= (text.bytes_left() + 1) / least_bytes) return {};
  return line_of(text) +
         fmt::format("announces {} {} in {} bytes, must have room for them", count, what, text.bytes_left());
}

/// Reads the keyword, if there is one, and the counts, which may stand in the same line. The keyword may begin with ST,
/// C and N: then more numbers follow on a vertex's coordinates, which are skipped as the rest of its line.
std::string read_head(TextCursor& text, std::array<std::uint64_t, kCounts>& counts) {
  std::string_view word = text.next_word_of_text();
  if (word.ends_with("OFF")) {
    const std::string_view before = word.substr(0, word.size() - 3);
    for (const std::string_view known : {"", "ST", "C", "STC", "N", "STN", "CN", "STCN"}) {
      if (before == known) word = text.next_word_of_text();
    }
  }
  for (std::size_t i = 0; i < kCounts; ++i) {
    // A line with two counts is read too.
    if (i == 2 && word.empty()) return {};
    if (!parse_number(word, counts[i]))
      return line_of(text) +
             fmt::format("the number of {} is '{}', must be a whole number", kCounted[i], shown_word(word));
    if (i + 1 < kCounts) word = i == 0 ? text.next_word_of_text() : text.next_word();
  }
  return {};
}

std::string read_vertices(TextCursor& text, std::uint64_t count, TriangleMesh& mesh) {
  if (std::string wrong = too_many(text, count, "vertices", kVertexBytes); !wrong.empty()) return wrong;
  mesh.vertices_m.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!text.next_line_with_words()) return line_of(text) + fmt::format("ends after {} of {} vertices", i, count);
    Vec3& vertex = mesh.vertices_m.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = text.next_word();
      if (!parse_finite(word, vertex[axis]))
        return line_of(text) +
               fmt::format("{} of vertex {} is '{}', must be a finite number", "xyz"[axis], i, shown_word(word));
    }
  }
  return {};
}

/// A face is its number of corners, the corners counted from 0, and perhaps a colour.
std::string read_face(TextCursor& text, std::vector<std::uint32_t>& corners) {
  std::uint64_t count = 0;
  const std::string_view first = text.next_word();
  if (!parse_number(first, count)) return fmt::format("corners = '{}', must be a whole number", shown_word(first));
  if (count > (text.bytes_left_of_line() + 1) / 2)
    return fmt::format("announces {} corners in {} bytes, must have room for them", count, text.bytes_left_of_line());
  corners.clear();
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string_view word = text.next_word();
    if (!parse_number(word, corners.emplace_back()))
      return fmt::format("corner {} of {} is '{}', must be the number of a vertex", i, count, shown_word(word));
  }
  return {};
}

std::string read_faces(TextCursor& text, std::uint64_t count, TriangleMesh& mesh) {
  if (std::string wrong = too_many(text, count, "faces", kFaceBytes); !wrong.empty()) return wrong;
  FaceList faces(mesh);
  std::vector<std::uint32_t> corners;
  mesh.triangles.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!text.next_line_with_words()) return line_of(text) + fmt::format("ends after {} of {} faces", i, count);
    std::string wrong = read_face(text, corners);
    if (wrong.empty()) wrong = faces.add(corners);
    if (!wrong.empty()) return fmt::format("line {}: face {}: {}", text.number(), i, wrong);
  }
  return {};
}

}  // namespace

Result<TriangleMesh> parse_off(std::string_view whole) {
  TextCursor text(whole, true);
  TriangleMesh mesh;
  std::array<std::uint64_t, kCounts> counts{};
  std::string wrong = read_head(text, counts);
  if (wrong.empty()) wrong = read_vertices(text, counts[0], mesh);
  if (wrong.empty()) wrong = read_faces(text, counts[1], mesh);
  if (!wrong.empty()) return bad_input(std::move(wrong));
  return mesh;
}

}  // namespace poise::geometry
