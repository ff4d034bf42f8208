// SPDX-License-Identifier: MIT
#include "assets/mesh/mesh_counts.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include <fmt/format.h>

#include "assets/files/text_words.h"

namespace poise::geometry {
namespace {

std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line.substr(0, line.find('#'));
}

/// The number at the beginning of a word, saturated to the largest value; 0 for none.
std::uint64_t leading_count(std::string_view word) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc::result_out_of_range ? UINT64_MAX : value;
}

std::string count_problem(const std::string& what, std::uint64_t count, std::uint64_t file_bytes) {
  if (count <= file_bytes) return {};
  return fmt::format("announces {} {} in {} bytes, must have room for them", count, what, file_bytes);
}

}  // namespace

std::string wrong_off_counts(std::string_view start, std::uint64_t file_bytes) {
  while (!start.empty()) {
    const std::vector<std::string_view> words = words_of(take_line(start));
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (words[i].front() < '0' || words[i].front() > '9') continue;
      // The first line with numbers holds the counts: vertices, faces, edges.
      std::string wrong = count_problem("vertices", leading_count(words[i]), file_bytes);
      if (wrong.empty() && i + 1 < words.size())
        wrong = count_problem("faces", leading_count(words[i + 1]), file_bytes);
      return wrong;
    }
  }
  return {};
}

std::string wrong_ply_counts(std::string_view start, std::uint64_t file_bytes) {
  bool has_faces = false;
  while (!start.empty()) {
    const std::vector<std::string_view> words = words_of(take_line(start));
    if (!words.empty() && words[0] == "end_header") {
      return has_faces ? "" : "has no triangle: its header has no element 'face'; points have no surface";
    }
    if (words.size() < 3 || words[0] != "element") continue;
    has_faces = has_faces || words[1] == "face" || words[1] == "tristrips";
    std::string wrong =
        count_problem(fmt::format("entries '{}'", words[1].substr(0, 40)), leading_count(words[2]), file_bytes);
    if (!wrong.empty()) return wrong;
  }
  return {};
}

}  // namespace poise::geometry
