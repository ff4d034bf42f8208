// SPDX-License-Identifier: MIT
#include "assets/tree/xml_ranges.h"

#include <algorithm>
#include <array>

namespace poise::geometry {
namespace {

struct Tag {
  std::size_t begin = 0, end = 0;
  std::string_view name;  ///< without the slash
  bool opens = false, closes = false;
};

std::size_t after(std::string_view text, std::string_view what, std::size_t from) {
  const std::size_t at = text.find(what, from);
  return at == std::string_view::npos ? text.size() : at + what.size();
}

/// Past the end of a tag: the first `>` outside of quotes.
std::size_t end_of_tag(std::string_view text, std::size_t from) {
  for (std::size_t i = from; i < text.size(); ++i) {
    if (text[i] == '>') return i + 1;
    if (text[i] == '"' || text[i] == '\'') i = std::min(text.find(text[i], i + 1), text.size());
  }
  return text.size();
}

/// The next tag from `at` on; `at` moves past it. False at the end.
bool next_tag(std::string_view text, std::size_t& at, Tag& tag) {
  for (;;) {
    at = text.find('<', at);
    if (at == std::string_view::npos) return false;
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<!--")) {
      at = after(text, "-->", at + 4);
    } else if (rest.starts_with("<![CDATA[")) {
      at = after(text, "]]>", at);
    } else if (rest.starts_with("<?")) {
      at = after(text, "?>", at);
    } else if (rest.starts_with("<!")) {
      at = after(text, ">", at);
    } else {
      break;
    }
  }
  tag.begin = at;
  tag.end = at = end_of_tag(text, at + 1);
  const bool slash = tag.end - tag.begin > 2 && text[tag.begin + 1] == '/';
  const std::size_t name = tag.begin + (slash ? 2 : 1);
  tag.name = text.substr(name, std::min(text.find_first_of(" \t\r\n/>", name), tag.end) - name);
  tag.opens = !slash;
  tag.closes = slash || (tag.end - tag.begin > 2 && text[tag.end - 2] == '/');
  return true;
}

}  // namespace

std::vector<XmlRange> xml_ranges(std::string_view text, std::string_view root, std::string_view outer,
                                 std::string_view inner) {
  const std::array<std::string_view, 3> wanted{root, outer, inner};
  std::vector<XmlRange> found;
  std::size_t depth = 0;    // of open elements
  std::size_t matched = 0;  // of these, the first so many have the names that are wanted
  Tag tag;
  for (std::size_t at = 0; next_tag(text, at, tag);) {
    if (tag.opens) {
      if (matched == depth && depth < wanted.size() && tag.name == wanted[depth]) {
        ++matched;
        if (depth == 1) found.push_back({tag.begin, tag.end, {}});
        if (depth == 2) found.back().inner.emplace_back(tag.begin, tag.end);
      }
      ++depth;
    }
    if (tag.closes && depth > 0) {
      if (matched == depth) {
        if (depth == 2) found.back().end_tag = tag.opens ? tag.end : tag.begin;
        if (depth == 3) found.back().inner.back().second = tag.end;
        --matched;
      }
      --depth;
    }
  }
  return found;
}

}  // namespace poise::geometry
