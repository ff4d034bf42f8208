// SPDX-License-Identifier: MIT
#pragma once

#include <tinyxml2.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"

namespace poise::io {

/// An MJCF model and the files that it includes, as one tree. Invariant: elements stay valid while it lives. As in
/// MuJoCo, a file is included once at most; together they are at most 64 files and 64 MiB, eight within
/// each other.
class MjcfDocument {
 public:
  using Element = tinyxml2::XMLElement;

  /// `name` is for messages, `folder` what included files are relative to. Refused: what is no XML, another root than
  /// <mujoco>, an included file that is missing, repeated or refused.
  static Result<MjcfDocument> open(const std::string& text, const std::string& name, std::filesystem::path folder);

  [[nodiscard]] const Element& root() const { return *root_; }
  /// The elements in an element, those of included files in the place of <include>.
  [[nodiscard]] std::vector<const Element*> children(const Element& element) const;
  /// `FILE: line 12: <geom>`.
  [[nodiscard]] std::string place(const Element& element) const;
  /// `line 12`, with the file if it is an included one.
  [[nodiscard]] std::string line(const Element& element) const;

 private:
  MjcfDocument() = default;
  Result<const Element*> parse(const std::string& text, const std::string& name);
  Status include_all(const Element& element, int depth);
  void add_children(const Element& element, std::vector<const Element*>& children) const;

  std::filesystem::path folder_;
  const Element* root_ = nullptr;
  std::vector<std::unique_ptr<tinyxml2::XMLDocument>> files_;  ///< the model first
  std::map<const tinyxml2::XMLDocument*, std::string> names_;
  std::map<const Element*, const Element*> included_;  ///< by <include>: the root of its file
  std::map<std::string, bool> seen_;                   ///< files that were included
  std::size_t bytes_ = 0;
};

/// Text of a file for a message, short and of printable ASCII.
std::string mjcf_shown(std::string_view text);

}  // namespace poise::io
