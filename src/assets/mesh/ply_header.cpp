// SPDX-License-Identifier: MIT
#include "assets/mesh/ply_header.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "assets/files/text_cursor.h"

namespace poise::geometry {
namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{{{"char", PlyType::Int8},
                                                                       {"uchar", PlyType::Uint8},
                                                                       {"short", PlyType::Int16},
                                                                       {"ushort", PlyType::Uint16},
                                                                       {"int", PlyType::Int32},
                                                                       {"uint", PlyType::Uint32},
                                                                       {"float", PlyType::Float32},
                                                                       {"double", PlyType::Float64},
                                                                       {"int8", PlyType::Int8},
                                                                       {"uint8", PlyType::Uint8},
                                                                       {"int16", PlyType::Int16},
                                                                       {"uint16", PlyType::Uint16},
                                                                       {"int32", PlyType::Int32},
                                                                       {"uint32", PlyType::Uint32},
                                                                       {"float32", PlyType::Float32},
                                                                       {"float64", PlyType::Float64}}};
constexpr std::array<std::pair<std::string_view, PlyForm>, 3> kForms{{{"ascii", PlyForm::Text},
                                                                      {"binary_little_endian", PlyForm::LittleEndFirst},
                                                                      {"binary_big_endian", PlyForm::BigEndFirst}}};

template <class Named>
std::string parse_name(const Named& names, std::string_view word, const char* what,
                       typename Named::value_type::second_type& value) {
  for (const auto& [name, named] : names) {
    if (name == word) {
      value = named;
      return {};
    }
  }
  return fmt::format("{} = '{}', must be a name that PLY has", what, shown_word(word));
}

std::string read_format(TextCursor& text, PlyHeader& header) {
  std::string wrong = parse_name(kForms, text.next_word(), "format", header.form);
  if (!wrong.empty()) return wrong;
  const std::string_view version = text.next_word();
  return version == "1.0" ? std::string() : fmt::format("version = '{}', must be 1.0", shown_word(version));
}

std::string read_element(TextCursor& text, PlyHeader& header) {
  PlyElement& element = header.elements.emplace_back();
  element.name = text.next_word();
  const std::string_view count = text.next_word();
  if (parse_number(count, element.count)) return {};
  return fmt::format("the count of element '{}' is '{}', must be a whole number", shown_word(element.name),
                     shown_word(count));
}

std::string read_property(TextCursor& text, PlyHeader& header) {
  if (header.elements.empty()) return "a property stands before the first element";
  PlyProperty property;
  std::string_view word = text.next_word();
  std::string wrong;
  if (word == "list") {
    wrong = parse_name(kTypes, text.next_word(), "type of a list's length", property.count.emplace());
    word = text.next_word();
  }
  if (wrong.empty()) wrong = parse_name(kTypes, word, "type of a property", property.type);
  if (wrong.empty() && property.count && !is_whole(*property.count)) wrong = "a list's length must be a whole number";
  property.name = text.next_word();
  if (wrong.empty() && property.name.empty()) wrong = "a property has no name";
  header.elements.back().properties.push_back(property);
  return wrong;
}

}  // namespace

std::size_t size_of(PlyType type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

bool is_whole(PlyType type) { return type != PlyType::Float32 && type != PlyType::Float64; }

std::optional<std::size_t> PlyElement::find(std::string_view property) const {
  const auto at = std::ranges::find(properties, property, &PlyProperty::name);
  if (at == properties.end()) return std::nullopt;
  return static_cast<std::size_t>(at - properties.begin());
}

std::size_t PlyElement::least_bytes(bool is_text) const {
  // A digit and a blank or line end for each.
  if (is_text) return std::max<std::size_t>(1, 2 * properties.size());
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) bytes += size_of(property.count.value_or(property.type));
  return std::max<std::size_t>(1, bytes);
}

Result<PlyHeader> read_ply_header(std::string_view whole) {
  PlyHeader header;
  // Of a binary file, too, only the header is text, so that its first line says what ends a line.
  if (whole.starts_with("ply\r") && !whole.starts_with("ply\r\n")) header.line_end = '\r';
  TextCursor text(whole, false, header.line_end);
  bool has_format = false;
  text.next_line();
  if (text.next_word() != "ply") return bad_input("line 1: not a PLY file: must begin with 'ply'");
  while (text.next_line()) {
    const std::string_view word = text.next_word();
    std::string wrong;
    if (word == "end_header") {
      text.skip_line();
      header.bytes = whole.size() - text.bytes_left();
      header.lines = text.number();
      if (!has_format) return bad_input("the header has no line 'format'");
      return header;
    }
    // Other lines are comments, whether or not they say so: files of Blender's do not.
    has_format = has_format || word == "format";
    if (word == "format") {
      wrong = read_format(text, header);
    } else if (word == "element") {
      wrong = read_element(text, header);
    } else if (word == "property") {
      wrong = read_property(text, header);
    }
    if (!wrong.empty()) return bad_input(fmt::format("line {}: {}", text.number(), wrong));
  }
  return bad_input(fmt::format("line {}: the header ends without 'end_header'", text.number()));
}

}  // namespace poise::geometry
