// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "assets/files/text_cursor.h"
#include "assets/mesh/byte_cursor.h"
#include "assets/mesh/face_list.h"
#include "assets/mesh/mesh_files.h"
#include "assets/mesh/ply_header.h"

namespace poise::geometry {
namespace {

/// The entries of a text: a line each, a word for each number.
class TextEntries {
 public:
  TextEntries(std::string_view text, const PlyHeader& header)
      : text_(text, false, header.line_end), lines_before_(header.lines) {}
  bool begin_entry() { return text_.next_line_with_words(); }
  bool real(PlyType /*type*/, double& value) { return parse_number(text_.next_word(), value); }
  bool whole(PlyType /*type*/, std::int64_t& value) { return parse_number(text_.next_word(), value); }
  bool skip(std::uint64_t count, PlyType /*type*/) {
    for (; count > 0; --count) {
      if (text_.next_word().empty()) return false;
    }
    return true;
  }
  [[nodiscard]] bool has_room(std::uint64_t count, PlyType /*type*/) const {
    return count <= (text_.bytes_left_of_line() + 1) / 2;
  }
  [[nodiscard]] std::string place() const { return fmt::format("line {}", lines_before_ + text_.number()); }

 private:
  TextCursor text_;
  std::size_t lines_before_;
};

/// The entries of a binary file.
class BinaryEntries {
 public:
  BinaryEntries(std::string_view bytes, std::size_t bytes_before, bool big_end_first)
      : bytes_(bytes), bytes_before_(bytes_before), big_end_first_(big_end_first) {}
  bool begin_entry() {
    begin_ = bytes_.at();
    return true;
  }
  bool real(PlyType type, double& value) {
    if (!bytes_.has(size_of(type))) return false;
    if (type == PlyType::Float64) {
      value = take<double>();
    } else if (type == PlyType::Float32) {
      value = static_cast<double>(take<float>());
    } else {
      value = static_cast<double>(take_whole(type));
    }
    return true;
  }
  bool whole(PlyType type, std::int64_t& value) {
    if (!bytes_.has(size_of(type))) return false;
    value = take_whole(type);
    return true;
  }
  bool skip(std::uint64_t count, PlyType type) {
    if (!has_room(count, type)) return false;
    bytes_.take(count * size_of(type));
    return true;
  }
  [[nodiscard]] bool has_room(std::uint64_t count, PlyType type) const {
    return count <= bytes_.left() / size_of(type);
  }
  [[nodiscard]] std::string place() const { return fmt::format("byte {}", bytes_before_ + begin_); }

 private:
  template <class Number>
  Number take() {
    return number_of_bytes<Number>(bytes_.take(sizeof(Number)), big_end_first_);
  }
  std::int64_t take_whole(PlyType type) {
    switch (type) {
      case PlyType::Int8:
        return take<std::int8_t>();
      case PlyType::Uint8:
        return take<std::uint8_t>();
      case PlyType::Int16:
        return take<std::int16_t>();
      case PlyType::Uint16:
        return take<std::uint16_t>();
      case PlyType::Int32:
        return take<std::int32_t>();
      case PlyType::Uint32:
      case PlyType::Float32:
      case PlyType::Float64:
        break;
    }
    return take<std::uint32_t>();
  }

  ByteCursor bytes_;
  std::size_t bytes_before_;
  std::size_t begin_ = 0;
  bool big_end_first_;
};

/// Reads the elements in the order of the file. What each function returns is wrong; empty for nothing.
template <class Entries>
class PlyReader {
 public:
  PlyReader(const PlyHeader& header, Entries entries)
      : header_(header), entries_(std::move(entries)), face_list_(mesh_) {}

  Result<TriangleMesh> read() {
    // Faces may stand before their vertices, so that they become triangles at the end.
    for (const PlyElement& element : header_.elements) {
      std::string wrong;
      if (element.name == "vertex") {
        wrong = read_vertices(element);
      } else if (element.name == "face" || element.name == "tristrips") {
        wrong = read_lists(element, element.name == "tristrips");
      } else {
        wrong = each_entry(element, [&] { return skip_all(element, 0, element.properties.size()); });
      }
      if (!wrong.empty()) return bad_input(std::move(wrong));
    }
    std::size_t begin = 0;
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      const std::span<const std::uint32_t> corners = std::span(corners_).subspan(begin, ends_[i] - begin);
      begin = ends_[i];
      if (const std::string wrong = face_list_.add(corners); !wrong.empty())
        return bad_input(fmt::format("face {}: {}", i, wrong));
    }
    return std::move(mesh_);
  }

 private:
  template <class Read>
  std::string each_entry(const PlyElement& element, Read&& read) {
    if (element.properties.empty()) return {};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      const bool begun = entries_.begin_entry();
      const std::string wrong = begun ? read() : std::string("the file ends here");
      if (!wrong.empty())
        return fmt::format("{}: entry {} of {} of '{}': {}", entries_.place(), i, element.count,
                           shown_word(element.name), wrong);
    }
    return {};
  }

  std::string skip_all(const PlyElement& element, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const PlyProperty& property = element.properties[p];
      std::uint64_t count = 1;
      if (property.count) {
        std::string wrong = read_length(property, count);
        if (!wrong.empty()) return wrong;
      }
      if (!entries_.skip(count, property.type))
        return fmt::format("ends within property '{}'", shown_word(property.name));
    }
    return {};
  }

  std::string read_length(const PlyProperty& property, std::uint64_t& count) {
    std::int64_t length = 0;
    if (!entries_.whole(*property.count, length))
      return fmt::format("the length of '{}' is missing or not a whole number", shown_word(property.name));
    if (length < 0 || !entries_.has_room(static_cast<std::uint64_t>(length), property.type))
      return fmt::format("the length of '{}' = {}, must be at least 0 and have room in the file",
                         shown_word(property.name), length);
    count = static_cast<std::uint64_t>(length);
    return {};
  }

  std::string read_vertices(const PlyElement& element) {
    std::array<std::size_t, 3> places{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto place = element.find(std::string_view("xyz").substr(axis, 1));
      if (!place || element.properties[*place].count)
        return fmt::format("element 'vertex' has no property '{}'", "xyz"[axis]);
      places[axis] = *place;
    }
    mesh_.vertices_m.reserve(mesh_.vertices_m.size() + element.count);
    const bool in_order = places[0] < places[1] && places[1] < places[2];
    return each_entry(element, [&]() -> std::string {
      Vec3& vertex = mesh_.vertices_m.emplace_back();
      if (!in_order) return read_vertex_anyhow(element, places, vertex);
      std::size_t next = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t place = places[static_cast<std::size_t>(axis)];
        std::string wrong = skip_all(element, next, place);
        if (wrong.empty()) wrong = read_coordinate(element.properties[place], axis, vertex);
        if (!wrong.empty()) return wrong;
        next = place + 1;
      }
      return skip_all(element, next, element.properties.size());
    });
  }
  std::string read_coordinate(const PlyProperty& property, int axis, Vec3& vertex) {
    if (entries_.real(property.type, vertex[axis]) && std::isfinite(vertex[axis])) return {};
    return fmt::format("{} is missing or not a finite number", "xyz"[axis]);
  }
  /// Coordinates in another order than x, y, z.
  std::string read_vertex_anyhow(const PlyElement& element, const std::array<std::size_t, 3>& places, Vec3& vertex) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const auto axis = std::ranges::find(places, p) - places.begin();
      std::string wrong = axis < 3 ? read_coordinate(element.properties[p], static_cast<int>(axis), vertex)
                                   : skip_all(element, p, p + 1);
      if (!wrong.empty()) return wrong;
    }
    return {};
  }

  std::string read_lists(const PlyElement& element, bool strips) {
    auto place = element.find("vertex_indices");
    if (!place) place = element.find("vertex_index");
    if (!place || !element.properties[*place].count || !is_whole(element.properties[*place].type))
      return fmt::format("element '{}' has no list 'vertex_indices' of whole numbers", element.name);
    const PlyProperty& list = element.properties[*place];
    return each_entry(element, [&]() -> std::string {
      std::uint64_t count = 0;
      std::string wrong = skip_all(element, 0, *place);
      if (wrong.empty()) wrong = read_length(list, count);
      if (wrong.empty()) wrong = strips ? read_strip(list.type, count) : read_face(list.type, count);
      return wrong.empty() ? skip_all(element, *place + 1, element.properties.size()) : wrong;
    });
  }
  bool read_corner(PlyType type, std::int64_t least, std::int64_t& corner) {
    return entries_.whole(type, corner) && corner >= least && corner < std::numeric_limits<std::uint32_t>::max();
  }
  std::string read_face(PlyType type, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
      std::int64_t corner = 0;
      if (!read_corner(type, 0, corner)) return fmt::format("corner {} of {} must be the number of a vertex", i, count);
      corners_.push_back(static_cast<std::uint32_t>(corner));
    }
    ends_.push_back(corners_.size());
    return {};
  }
  /// Triangles that share edges; every second one is turned over, and -1 begins anew.
  std::string read_strip(PlyType type, std::uint64_t count) {
    std::array<std::uint32_t, 2> before{};
    std::uint64_t length = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      std::int64_t corner = 0;
      if (!read_corner(type, -1, corner))
        return fmt::format("corner {} of {} must be the number of a vertex", i, count);
      if (corner < 0) {
        length = 0;
        continue;
      }
      const auto at = static_cast<std::uint32_t>(corner);
      if (length >= 2) {
        const bool turned = length % 2 == 1;
        for (const std::uint32_t c : {before[turned ? 1 : 0], before[turned ? 0 : 1], at}) corners_.push_back(c);
        ends_.push_back(corners_.size());
      }
      before = {before[1], at};
      ++length;
    }
    return {};
  }

  const PlyHeader& header_;
  Entries entries_;
  TriangleMesh mesh_;
  FaceList face_list_;
  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> ends_;  ///< of the faces in corners_
};

}  // namespace

Result<TriangleMesh> parse_ply(std::string_view bytes) {
  const std::string_view whole = without_byte_order_mark(bytes);
  const Result<PlyHeader> read = read_ply_header(whole);
  if (!read) return read.error();
  const PlyHeader& header = read.value();
  const auto has = [&](std::string_view name) {
    return std::ranges::find(header.elements, name, &PlyElement::name) != header.elements.end();
  };
  if (!has("face") && !has("tristrips"))
    return bad_input("has no triangle: its header has no element 'face'; points have no surface");
  const std::string_view entries = whole.substr(header.bytes);
  for (const PlyElement& element : header.elements) {
    if (element.count > (entries.size() + 1) / element.least_bytes(header.form == PlyForm::Text))
      return bad_input(fmt::format("announces {} entries '{}' in {} bytes, must have room for them", element.count,
                                   shown_word(element.name), entries.size()));
  }
  if (header.form == PlyForm::Text) return PlyReader(header, TextEntries(entries, header)).read();
  const std::size_t before = bytes.size() - entries.size();
  return PlyReader(header, BinaryEntries(entries, before, header.form == PlyForm::BigEndFirst)).read();
}

}  // namespace poise::geometry
