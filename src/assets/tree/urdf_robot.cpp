// SPDX-License-Identifier: MIT
#include "assets/tree/urdf_robot.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "assets/files/text_words.h"
#include "assets/tree/tree_files.h"
#include "assets/tree/xml_ranges.h"
#include "math/functions.h"

namespace poise::geometry {
namespace {

using tinyxml2::XMLElement;

constexpr double kMostMetres = 1e9;
constexpr double kLeastMetres = 1e-9;

std::string element_place(const XMLElement& element) {
  return fmt::format("line {}: <{}>", element.GetLineNum(), shown_text(element.Name()));
}

/// Reads `count` numbers of an attribute into the first components; without the attribute they stay, unless it is
/// required.
Status read_attribute(const XMLElement& element, const char* name, int count, bool required, Vec3& numbers) {
  const char* text = element.Attribute(name);
  if (text == nullptr && !required) return Done{};
  const std::vector<std::string_view> words = words_of(text != nullptr ? text : "");
  bool sound = words.size() == static_cast<std::size_t>(count);
  for (int i = 0; i < count && sound; ++i)
    sound = read_number(words[static_cast<std::size_t>(i)], numbers[i]) && std::abs(numbers[i]) <= kMostMetres;
  if (sound) return Done{};
  return bad_input(fmt::format("{}: {} = '{}', must be {} number{} within {}", element_place(element), name,
                               shown_text(text != nullptr ? text : ""), count, count == 1 ? "" : "s", kMostMetres));
}

Status read_lengths(const XMLElement& element, const char* name, int count, Vec3& lengths) {
  const Status read = read_attribute(element, name, count, true, lengths);
  if (!read) return read;
  for (int i = 0; i < count; ++i) {
    if (!(lengths[i] >= kLeastMetres))
      return bad_input(
          fmt::format("{}: {} = {}, must be at least {} m", element_place(element), name, lengths[i], kLeastMetres));
  }
  return Done{};
}

Status read_mesh_part(const XMLElement& mesh, UrdfPart& part) {
  const char* file = mesh.Attribute("filename");
  if (file == nullptr || *file == '\0') return bad_input(element_place(mesh) + ": filename must name a mesh");
  part.file = file;
  const Status read = read_attribute(mesh, "scale", 3, false, part.scale);
  if (!read) return read;
  if (part.scale.cwiseAbs().minCoeff() < kLeastMetres)
    return bad_input(element_place(mesh) + ": scale must not be 0 along any axis");
  return Done{};
}

Status read_urdf_shape(const XMLElement& shape, UrdfPart& part) {
  const std::string_view kind = shape.Name();
  if (kind == "mesh") return read_mesh_part(shape, part);
  if (kind == "box") {
    part.solid = UrdfSolid::Box;
    return read_lengths(shape, "size", 3, part.size_m);
  }
  if (kind == "sphere") {
    part.solid = UrdfSolid::Sphere;
    return read_lengths(shape, "radius", 1, part.size_m);
  }
  if (kind != "cylinder")
    return bad_input(element_place(shape) + ": is no shape of URDF, must be mesh, box, cylinder or sphere");
  part.solid = UrdfSolid::Cylinder;
  Vec3 length = Vec3::Zero();
  Status read = read_lengths(shape, "radius", 1, part.size_m);
  if (read) read = read_lengths(shape, "length", 1, length);
  part.size_m.y() = length.x();
  return read;
}

/// A `<collision>` or `<visual>`.
Result<UrdfPart> read_part(const XMLElement& owner) {
  const XMLElement* geometry = owner.FirstChildElement("geometry");
  const XMLElement* shape = geometry != nullptr ? geometry->FirstChildElement() : nullptr;
  if (shape == nullptr) return bad_input(element_place(owner) + ": must have a <geometry> with a shape");
  UrdfPart part;
  part.line = shape->GetLineNum();
  if (const XMLElement* origin = owner.FirstChildElement("origin")) {
    Vec3 rpy = Vec3::Zero();
    Status read = read_attribute(*origin, "xyz", 3, false, part.position_m);
    if (read) read = read_attribute(*origin, "rpy", 3, false, rpy);
    if (!read) return read.error();
    part.rotation = rotation_of_rpy(rpy);
  }
  const Status read = read_urdf_shape(*shape, part);
  if (!read) return read.error();
  return part;
}

Result<UrdfLink> read_link(const XMLElement& element) {
  UrdfLink link;
  const char* name = element.Attribute("name");
  if (name == nullptr || *name == '\0') return bad_input(element_place(element) + ": must have a name");
  link.name = name;
  link.from_visual = element.FirstChildElement("collision") == nullptr;
  const char* of = link.from_visual ? "visual" : "collision";
  for (const XMLElement* e = element.FirstChildElement(of); e != nullptr; e = e->NextSiblingElement(of)) {
    Result<UrdfPart> part = read_part(*e);
    if (!part) return part.error();
    link.parts.push_back(std::move(part).value());
  }
  return link;
}

/// A line of XML for each sphere, with the blanks that stand before the first.
std::string sphere_lines(const std::vector<Sphere>& spheres, const std::string& indent) {
  std::string text;
  for (const Sphere& s : spheres) {
    text += fmt::format(
        "{}<collision><origin xyz=\"{} {} {}\" rpy=\"0 0 0\"/><geometry><sphere radius=\"{}\"/></geometry></collision>",
        text.empty() ? "" : "\n" + indent, s.center_m.x(), s.center_m.y(), s.center_m.z(), s.radius_m);
  }
  return text;
}

/// The blanks between `at` and the line end before it; empty where something else stands there.
std::string indent_before(const std::string& text, std::size_t at) {
  std::size_t begin = at;
  while (begin > 0 && (text[begin - 1] == ' ' || text[begin - 1] == '\t')) --begin;
  return begin == 0 || text[begin - 1] == '\n' ? text.substr(begin, at - begin) : "";
}

/// Whether a text that was changed has the links that it had, with their spheres. The parser takes texts that are not
/// quite XML (several roots, say), of which xml_ranges may find other elements.
bool has_spheres(const std::string& text, const std::vector<UrdfLink>& before,
                 std::span<const std::optional<std::vector<Sphere>>> spheres) {
  const Result<std::vector<UrdfLink>> links = urdf_links(text);
  if (!links || links.value().size() != before.size()) return false;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const UrdfLink& link = links.value()[i];
    if (link.name != before[i].name) return false;
    if (!spheres[i] && link.parts.size() != before[i].parts.size()) return false;
    if (spheres[i] && (!link.only_spheres() || link.parts.size() != spheres[i]->size())) return false;
  }
  return true;
}

}  // namespace

bool UrdfLink::only_spheres() const {
  return !from_visual &&
         std::ranges::all_of(parts, [](const UrdfPart& part) { return part.solid == UrdfSolid::Sphere; });
}

Mat3 rotation_of_rpy(const Vec3& rpy_rad) {
  const math::SinCos r = math::sin_cos(rpy_rad.x());
  const math::SinCos p = math::sin_cos(rpy_rad.y());
  const math::SinCos y = math::sin_cos(rpy_rad.z());
  Mat3 about_x;
  Mat3 about_y;
  Mat3 about_z;
  about_x << 1, 0, 0, 0, r.cos, -r.sin, 0, r.sin, r.cos;
  about_y << p.cos, 0, p.sin, 0, 1, 0, -p.sin, 0, p.cos;
  about_z << y.cos, -y.sin, 0, y.sin, y.cos, 0, 0, 0, 1;
  return about_z * about_y * about_x;
}

Result<std::vector<UrdfLink>> urdf_links(const std::string& text) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS)
    return bad_input(fmt::format("line {}: not valid XML ({})", document.ErrorLineNum(), document.ErrorName()));
  const XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) return bad_input("must be a URDF with a <robot>");
  std::vector<UrdfLink> links;
  std::set<std::string> names;
  for (const XMLElement* e = robot->FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    if (std::string_view(e->Name()).starts_with("xacro:"))
      return bad_input(element_place(*e) +
                       ": is a macro of xacro, must be expanded before (xacro robot.xacro > robot.urdf)");
    if (std::string_view(e->Name()) != "link") continue;
    Result<UrdfLink> link = read_link(*e);
    if (!link) return link.error();
    if (!names.insert(link.value().name).second)
      return bad_input(
          fmt::format("{}: name '{}' is that of another link", element_place(*e), shown_text(link.value().name)));
    links.push_back(std::move(link).value());
  }
  if (links.empty()) return bad_input("has no <link>");
  return links;
}

Result<std::string> with_collision_spheres(const std::string& text,
                                           std::span<const std::optional<std::vector<Sphere>>> spheres) {
  const Result<std::vector<UrdfLink>> links = urdf_links(text);
  if (!links) return links.error();
  const std::vector<XmlRange> found = xml_ranges(text, "robot", "link", "collision");
  if (found.size() != links.value().size() || found.size() != spheres.size())
    return bad_input("cannot be written back: its links cannot be told apart");
  std::string written;
  std::size_t copied = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!spheres[i]) continue;
    const XmlRange& link = found[i];
    if (link.inner.empty()) {
      // Behind the last thing of the link, where the indent of the line of </link> begins.
      const std::string outer = indent_before(text, link.end_tag);
      const std::size_t at = link.end_tag - outer.size();
      written.append(text, copied, at - copied);
      const std::string indent = outer + "  ";
      written += indent + sphere_lines(*spheres[i], indent) + "\n";
      copied = at;
      continue;
    }
    for (std::size_t k = 0; k < link.inner.size(); ++k) {
      const auto& [begin, end] = link.inner[k];
      const std::string indent = indent_before(text, begin);
      if (k == 0) {
        written.append(text, copied, begin - copied);
        written += sphere_lines(*spheres[i], indent);
      } else {
        // With the line end before it, so that no empty line is left.
        std::size_t from = begin - indent.size();
        if (from > copied && text[from - 1] == '\n') --from;
        if (from > copied && text[from - 1] == '\r') --from;
        written.append(text, copied, from - copied);
      }
      copied = end;
    }
  }
  written.append(text, copied);
  if (!has_spheres(written, links.value(), spheres))
    return bad_input("cannot be written back: its XML can be read in more than one way");
  return written;
}

}  // namespace poise::geometry
