// SPDX-License-Identifier: MIT
#include "scene/import/mjcf_document.h"

#include <fmt/format.h>

#include <utility>

#include "assets/files/text_file.h"
#include "assets/tree/tree_files.h"

namespace poise::io {
namespace {

constexpr std::size_t kMostIncluded = 64;
/// Each file may nest a hundred elements, so that what walks the tree stays far from the end of its stack.
constexpr int kDeepestInclude = 8;
constexpr std::size_t kMostModelBytes = 64ULL << 20U;

bool is_include(const tinyxml2::XMLElement& element) { return std::string_view(element.Name()) == "include"; }

}  // namespace

std::string mjcf_shown(std::string_view text) { return geometry::shown_text(text); }

Result<MjcfDocument> MjcfDocument::open(const std::string& text, const std::string& name,
                                        std::filesystem::path folder) {
  MjcfDocument document;
  document.folder_ = std::move(folder);
  const Result<const Element*> root = document.parse(text, name);
  if (!root) return root.error();
  document.root_ = root.value();
  if (std::string_view(document.root_->Name()) != "mujoco")
    return bad_input(fmt::format("{}: must be a model of MuJoCo, with a <mujoco>, not <{}>", name,
                                 mjcf_shown(document.root_->Name())));
  const Status included = document.include_all(*document.root_, 0);
  if (!included) return included.error();
  return document;
}

Result<const MjcfDocument::Element*> MjcfDocument::parse(const std::string& text, const std::string& name) {
  bytes_ += text.size();
  if (bytes_ > kMostModelBytes) return bad_input(name + ": with what it includes it has more than 64 MiB");
  auto& file = *files_.emplace_back(std::make_unique<tinyxml2::XMLDocument>());
  names_[&file] = one_line(name);
  if (file.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS || file.RootElement() == nullptr)
    return bad_input(fmt::format("{}: line {}: not valid XML ({})", name, file.ErrorLineNum(), file.ErrorName()));
  return file.RootElement();
}

Status MjcfDocument::include_all(const Element& element, int depth) {
  for (const Element* e = element.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    if (!is_include(*e)) {
      const Status inside = include_all(*e, depth);
      if (!inside) return inside;
      continue;
    }
    const char* file = e->Attribute("file");
    if (file == nullptr || *file == '\0') return bad_input(place(*e) + ": file must name a file");
    if (files_.size() > kMostIncluded)
      return bad_input(fmt::format("{}: one file too many, at most {} may be included", place(*e), kMostIncluded));
    if (depth >= kDeepestInclude)
      return bad_input(fmt::format("{}: is in {} included files, at most {}", place(*e), depth, kDeepestInclude));
    if (!seen_.emplace(file, true).second)
      return bad_input(fmt::format("{}: file = '{}', may be included once", place(*e), mjcf_shown(file)));
    const std::filesystem::path path = folder_ / file;
    const Result<std::string> text = geometry::read_bytes(path, kMostModelBytes);
    if (!text) return bad_input(fmt::format("{}: file = '{}': {}", place(*e), mjcf_shown(file), text.error().message));
    const Result<const Element*> root = parse(text.value(), path.string());
    if (!root) return root.error();
    included_[e] = root.value();
    const Status inside = include_all(*root.value(), depth + 1);
    if (!inside) return inside;
  }
  return Done{};
}

std::vector<const MjcfDocument::Element*> MjcfDocument::children(const Element& element) const {
  std::vector<const Element*> found;
  add_children(element, found);
  return found;
}

void MjcfDocument::add_children(const Element& element, std::vector<const Element*>& found) const {
  for (const Element* e = element.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    if (is_include(*e)) {
      add_children(*included_.at(e), found);
    } else {
      found.push_back(e);
    }
  }
}

std::string MjcfDocument::place(const Element& element) const {
  return fmt::format("{}: line {}: <{}>", names_.at(element.GetDocument()), element.GetLineNum(),
                     mjcf_shown(element.Name()));
}

std::string MjcfDocument::line(const Element& element) const {
  const bool model = element.GetDocument() == files_.front().get();
  return fmt::format("{}line {}", model ? "" : names_.at(element.GetDocument()) + " ", element.GetLineNum());
}

}  // namespace poise::io
