// SPDX-License-Identifier: MIT
#include "poise/assets/tree_formats.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <utility>

#include <fmt/format.h>

#include "assets/files/atomic_file.h"
#include "assets/files/text_file.h"
#include "assets/files/text_words.h"
#include "assets/tree/tree_files.h"
#include "geometry/primitives/rounding.h"
#include "geometry/sphere_tree/tree_check.h"
#include "poise/assets/sph_file.h"

namespace poise {
namespace {

/// A level of spheres takes about 100 bytes a sphere; chosen.
constexpr std::uint64_t kMaxTreeFileBytes = 64ULL << 20;
constexpr std::size_t kLongestName = 256;

/// Length of the UTF-8 character that begins here, or 0 (RFC 3629: no overlong forms, no surrogates, at most U+10FFFF).
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return 0;
  }
  const unsigned second = byte(1);
  if ((lead == 0xe0 && second < 0xa0) || (lead == 0xed && second > 0x9f)) return 0;
  if ((lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second > 0x8f)) return 0;
  return length;
}

/// What is wrong with a name in any of the formats; empty if it is valid in all.
std::string wrong_name(std::string_view name) {
  if (name.empty()) return "must not be empty";
  if (name.size() > kLongestName)
    return fmt::format("has {} bytes, at most {} are accepted", name.size(), kLongestName);
  for (std::string_view rest = name; !rest.empty();) {
    const std::size_t length = character_length(rest);
    if (length == 0) return "must be UTF-8";
    const auto first = static_cast<unsigned char>(rest[0]);
    const bool c1 = length == 2 && first == 0xc2 && static_cast<unsigned char>(rest[1]) < 0xa0;
    // U+FFFE and U+FFFF are not allowed in XML.
    const bool no_xml = length == 3 && first == 0xef && static_cast<unsigned char>(rest[1]) == 0xbf &&
                        static_cast<unsigned char>(rest[2]) >= 0xbe;
    if (first < 0x20 || first == 0x7f || c1 || no_xml) return "must not contain control characters";
    rest.remove_prefix(length);
  }
  return {};
}

std::vector<Sphere> spheres_at(const SphereTree& tree, Level level) {
  std::vector<Sphere> spheres;
  for (const NodeIndex node : tree.nodes_at(level)) spheres.push_back(tree.sphere(node));
  return spheres;
}

Result<std::vector<Sphere>> sph_spheres(const std::filesystem::path& file, const SphereChoice& choice) {
  const Result<SphereTree> tree = read_sph(file);
  if (!tree) return tree.error();
  const Level level = choice.level.value_or(tree.value().depth());
  if (level > tree.value().depth()) {
    return bad_input(fmt::format("{}: has no level {}, the deepest is {}", file.string(), level, tree.value().depth()));
  }
  return spheres_at(tree.value(), level);
}

Result<std::vector<Sphere>> parse_spheres(TreeFormat format, const std::string& text, const SphereChoice& choice) {
  switch (format) {
    case TreeFormat::Urdf:
      return geometry::urdf_spheres(text, choice);
    case TreeFormat::CuroboYaml:
      return geometry::curobo_spheres(text, choice);
    case TreeFormat::Sph:
    case TreeFormat::FoamJson:
      break;
  }
  return geometry::foam_spheres(text, choice);
}

}  // namespace

std::optional<TreeFormat> tree_format_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  constexpr std::array<std::pair<std::string_view, TreeFormat>, 5> kEndings{{{".sph", TreeFormat::Sph},
                                                                             {".urdf", TreeFormat::Urdf},
                                                                             {".yml", TreeFormat::CuroboYaml},
                                                                             {".yaml", TreeFormat::CuroboYaml},
                                                                             {".json", TreeFormat::FoamJson}}};
  for (const auto& [known, format] : kEndings) {
    if (ending == known) return format;
  }
  return std::nullopt;
}

Status write_tree(const SphereTree& tree, Level level, TreeFormat format, const std::string& name,
                  const std::filesystem::path& file) {
  if (format == TreeFormat::Sph) return write_sph(tree, file);
  if (format > TreeFormat::FoamJson)
    return bad_input(fmt::format("format = {}, must be one of TreeFormat", static_cast<int>(format)));
  if (std::string wrong = geometry::why_not_tree(tree); !wrong.empty()) return bad_input(std::move(wrong));
  if (format != TreeFormat::FoamJson) {
    if (const std::string wrong = wrong_name(name); !wrong.empty()) {
      return bad_input(fmt::format("name '{}' {}", geometry::shown_text(name), wrong));
    }
  }
  try {
    std::string text;
    if (format == TreeFormat::Urdf) text = geometry::urdf_text(spheres_at(tree, level), name);
    if (format == TreeFormat::CuroboYaml) text = geometry::curobo_text(spheres_at(tree, level), name);
    if (format == TreeFormat::FoamJson) text = geometry::foam_text(tree, level);
    return geometry::write_file(file, text);
  } catch (const std::exception& failure) {
    return Error{ErrorKind::OutputFailed, fmt::format("{}: cannot be written: {}", file.string(), failure.what())};
  }
}

Result<std::vector<Sphere>> read_spheres(const std::filesystem::path& file, const SphereChoice& choice) {
  try {
    const std::optional<TreeFormat> format = tree_format_of(file);
    if (!format) return bad_input(fmt::format("{}: must end in .sph, .urdf, .yml, .yaml or .json", file.string()));
    if (*format == TreeFormat::Sph) {
      Result<std::vector<Sphere>> spheres = sph_spheres(file, choice);
      if (spheres && spheres.value().size() > kMaxUnionSpheres) {
        return bad_input(fmt::format("{}: {} spheres, at most {} are accepted", file.string(), spheres.value().size(),
                                     kMaxUnionSpheres));
      }
      return spheres;
    }
    const Result<std::string> text = geometry::read_text_file(file, kMaxTreeFileBytes);
    if (!text) return text.error();
    Result<std::vector<Sphere>> spheres = parse_spheres(*format, text.value(), choice);
    if (!spheres) return bad_input(fmt::format("{}: {}", file.string(), spheres.error().message));
    if (spheres.value().empty())
      return bad_input(fmt::format("{}: has no spheres, at least one is needed", file.string()));
    return spheres;
  } catch (const std::exception& failure) {
    return bad_input(fmt::format("{}: {}", file.string(), failure.what()));
  }
}

namespace geometry {

LevelErrors level_errors(const SphereTree& tree, std::span<const NodeIndex> nodes) {
  LevelErrors errors;
  if (nodes.empty()) return errors;
  errors.best_m = static_cast<double>(tree.protrusion_max_m[nodes[0]]);
  for (const NodeIndex node : nodes) {
    const auto error_m = static_cast<double>(tree.protrusion_max_m[node]);
    errors.best_m = std::min(errors.best_m, error_m);
    errors.worst_m = std::max(errors.worst_m, error_m);
    errors.mean_m += error_m / static_cast<double>(nodes.size());
  }
  return errors;
}

bool protrusions_known(const SphereTree& tree) {
  const auto nodes = std::span(tree.protrusion_max_m).first(tree.node_count());
  return nodes.size() == 1 || std::ranges::any_of(nodes, [](float protrusion_m) { return protrusion_m != 0; });
}

bool read_number(std::string_view text, double& value) {
  const std::vector<std::string_view> words = words_of(text);
  if (words.size() != 1) return false;
  std::string_view word = words[0];
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size() && std::isfinite(value);
}

Status take_sphere(const Sphere& sphere, const std::string& place, std::vector<Sphere>& spheres) {
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(sphere.center_m[i]) <= kLargestLength_m)) {
      return bad_input(
          fmt::format("{}: coordinate = {}, must be within {} m", place, sphere.center_m[i], kLargestLength_m));
    }
  }
  if (!(sphere.radius_m >= kSmallestLength_m && sphere.radius_m <= kLargestLength_m)) {
    return bad_input(fmt::format("{}: radius = {}, must be from {} to {} m", place, sphere.radius_m, kSmallestLength_m,
                                 kLargestLength_m));
  }
  if (spheres.size() >= kMaxUnionSpheres) {
    return bad_input(fmt::format("{}: one sphere too many, at most {} are accepted", place, kMaxUnionSpheres));
  }
  spheres.push_back(sphere);
  return Done{};
}

Result<std::string> chosen_link(const std::vector<std::string>& links, const std::string& choice) {
  if (links.empty()) return bad_input("no link has spheres");
  if (choice.empty() && links.size() == 1) return links[0];
  if (!choice.empty() && std::ranges::find(links, choice) != links.end()) return choice;
  constexpr std::size_t kNamed = 8;
  std::string named;
  for (std::size_t i = 0; i < links.size() && i < kNamed; ++i) named += (i > 0 ? ", " : "") + shown_text(links[i]);
  if (links.size() > kNamed) named += fmt::format(" and {} more", links.size() - kNamed);
  if (choice.empty()) return bad_input("several links have spheres, one must be chosen: " + named);
  return bad_input(fmt::format("no link '{}' with spheres; there are: {}", shown_text(choice), named));
}

std::string shown_text(std::string_view text, std::size_t longest) {
  std::string shown(text.substr(0, longest));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.size() > longest ? shown + "..." : shown;
}

}  // namespace geometry
}  // namespace poise
