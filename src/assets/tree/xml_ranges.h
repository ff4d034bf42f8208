// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

namespace poise::geometry {

/// Where an element is in a text, in bytes.
struct XmlRange {
  std::size_t begin = 0;                                   ///< of its first tag
  std::size_t end_tag = 0;                                 ///< begin of its last tag; of an empty element, its end
  std::vector<std::pair<std::size_t, std::size_t>> inner;  ///< begin and end of children that were asked for
};

/// The elements ROOT/OUTER of a text that is sound XML, in order, and of each its children INNER, so that a text can be
/// changed there and nowhere else. Comments and CDATA are passed over.
std::vector<XmlRange> xml_ranges(std::string_view text, std::string_view root, std::string_view outer,
                                 std::string_view inner);

}  // namespace poise::geometry
