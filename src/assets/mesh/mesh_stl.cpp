// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "assets/files/text_cursor.h"
#include "assets/mesh/byte_cursor.h"
#include "assets/mesh/mesh_files.h"

namespace poise::geometry {
namespace {

// A binary file is 80 bytes of any content, the number of triangles and for each of them normal, three corners and two
// bytes more.
constexpr std::size_t kStlHeadBytes = 84;
constexpr std::size_t kStlTriangleBytes = 50;
constexpr std::size_t kStlNormalBytes = 12;

void add_triangle(TriangleMesh& mesh) {
  const auto end = static_cast<std::uint32_t>(mesh.vertices_m.size());
  mesh.triangles.push_back({end - 3, end - 2, end - 1});
}

Result<TriangleMesh> parse_binary(std::string_view bytes, std::uint32_t count) {
  TriangleMesh mesh;
  mesh.vertices_m.reserve(std::size_t{3} * count);
  mesh.triangles.reserve(count);
  ByteCursor cursor(bytes.substr(kStlHeadBytes));
  for (std::uint32_t i = 0; i < count; ++i) {
    const char* corner = cursor.take(kStlTriangleBytes) + kStlNormalBytes;
    for (int k = 0; k < 3; ++k) {
      Vec3& vertex = mesh.vertices_m.emplace_back();
      for (int axis = 0; axis < 3; ++axis, corner += sizeof(float)) {
        vertex[axis] = static_cast<double>(number_of_bytes<float>(corner, false));
        if (!std::isfinite(vertex[axis]))
          return bad_input(fmt::format("byte {}: {} of corner {} of triangle {} is {}, must be finite",
                                       corner - bytes.data(), "xyz"[axis], k, i, vertex[axis]));
      }
    }
    add_triangle(mesh);
  }
  return mesh;
}

bool is_word(std::string_view word, std::string_view lower) {
  if (word == lower) return true;
  return word.size() == lower.size() && std::ranges::equal(word, lower, [](char a, char b) {
           return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
         });
}

/// Reads the text form; each function returns what is wrong, empty for nothing.
class SolidReader {
 public:
  explicit SolidReader(std::string_view text) : text_(text, false) {}

  Result<TriangleMesh> read() {
    for (;;) {
      const std::string_view word = text_.next_word_of_text();
      if (word.empty()) return std::move(mesh_);
      std::string wrong = is_word(word, "solid") ? solid() : refused(word, "solid");
      if (!wrong.empty()) return bad_input(fmt::format("line {}: {}", text_.number(), wrong));
    }
  }

 private:
  static std::string refused(std::string_view word, std::string_view wanted) {
    if (word.empty()) return fmt::format("the file ends where '{}' should stand", wanted);
    return fmt::format("'{}' stands where '{}' should", shown_word(word), wanted);
  }
  std::string expect(std::string_view wanted) {
    const std::string_view word = text_.next_word_of_text();
    return is_word(word, wanted) ? std::string() : refused(word, wanted);
  }
  /// A name may be any text to the end of its line.
  std::string solid() {
    text_.skip_line();
    for (;;) {
      const std::string_view word = text_.next_word_of_text();
      if (is_word(word, "endsolid")) break;
      std::string wrong = is_word(word, "facet") ? facet() : refused(word, "facet' or 'endsolid");
      if (!wrong.empty()) return wrong;
    }
    text_.skip_line();
    return {};
  }
  /// The normal is not used: it follows from the corners, and writers give any.
  std::string facet() {
    for (std::string_view word = text_.next_word_of_text(); !is_word(word, "outer"); word = text_.next_word_of_text()) {
      if (word.empty() || is_word(word, "endfacet")) return refused(word, "outer");
    }
    std::string wrong = expect("loop");
    for (int i = 0; i < 3 && wrong.empty(); ++i) {
      wrong = expect("vertex");
      if (wrong.empty()) wrong = vertex();
    }
    for (const char* closing : {"endloop", "endfacet"}) {
      if (wrong.empty()) wrong = expect(closing);
    }
    if (wrong.empty()) add_triangle(mesh_);
    return wrong;
  }
  std::string vertex() {
    Vec3& vertex = mesh_.vertices_m.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = text_.next_word_of_text();
      if (!parse_finite(word, vertex[axis]))
        return fmt::format("{} of a vertex is '{}', must be a finite number", "xyz"[axis], shown_word(word));
    }
    return {};
  }

  TextCursor text_;
  TriangleMesh mesh_;
};

}  // namespace

Result<TriangleMesh> parse_stl(std::string_view bytes) {
  if (bytes.size() >= kStlHeadBytes) {
    const auto count = number_of_bytes<std::uint32_t>(bytes.data() + kStlHeadBytes - sizeof(std::uint32_t), false);
    // The head of a binary file may begin with "solid" too, so that its length decides.
    if (bytes.size() == kStlHeadBytes + kStlTriangleBytes * std::size_t{count}) return parse_binary(bytes, count);
  }
  const std::string_view text = without_byte_order_mark(bytes);
  TextCursor first(text.substr(0, kStlHeadBytes), false);
  if (is_word(first.next_word_of_text(), "solid")) return SolidReader(text).read();
  if (bytes.size() < kStlHeadBytes)
    return bad_input(
        fmt::format("has {} bytes, must begin with 'solid' or with a head of {} bytes", bytes.size(), kStlHeadBytes));
  const auto count = number_of_bytes<std::uint32_t>(bytes.data() + kStlHeadBytes - sizeof(std::uint32_t), false);
  return bad_input(fmt::format("byte 80: announces {} triangles, must then have {} bytes, has {}", count,
                               kStlHeadBytes + kStlTriangleBytes * std::size_t{count}, bytes.size()));
}

}  // namespace poise::geometry
