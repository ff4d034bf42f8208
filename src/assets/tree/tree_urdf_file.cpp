// SPDX-License-Identifier: MIT
#include <tinyxml2.h>

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "assets/files/text_words.h"
#include "assets/tree/tree_files.h"

namespace poise::geometry {
namespace {

using tinyxml2::XMLElement;

std::string place_of(const XMLElement& element) {
  return fmt::format("line {}: <{}>", element.GetLineNum(), shown_text(element.Name()));
}

Status read_origin(const XMLElement& origin, Vec3& center_m) {
  const char* xyz = origin.Attribute("xyz");
  if (xyz == nullptr) return Done{};
  const std::vector<std::string_view> words = words_of(xyz);
  for (std::size_t i = 0; i < 3; ++i) {
    if (words.size() != 3 || !read_number(words[i], center_m[static_cast<int>(i)])) {
      return bad_input(fmt::format("{}: xyz = '{}', must be three numbers", place_of(origin), shown_text(xyz)));
    }
  }
  return Done{};
}

/// A sphere is symmetric, so the rpy of an origin is ignored.
Status read_collision(const XMLElement& collision, std::vector<Sphere>& spheres) {
  const XMLElement* geometry = collision.FirstChildElement("geometry");
  const XMLElement* shape = geometry != nullptr ? geometry->FirstChildElement() : nullptr;
  if (shape == nullptr) return bad_input(place_of(collision) + ": must have a <geometry> with a shape");
  if (std::string_view(shape->Name()) != "sphere") return bad_input(place_of(*shape) + ": only spheres can be read");
  Sphere sphere;
  if (const XMLElement* origin = collision.FirstChildElement("origin")) {
    const Status read = read_origin(*origin, sphere.center_m);
    if (!read) return read;
  }
  const char* radius = shape->Attribute("radius");
  if (radius == nullptr || !read_number(radius, sphere.radius_m)) {
    return bad_input(fmt::format("{}: radius = '{}', must be a number", place_of(*shape),
                                 shown_text(radius != nullptr ? radius : "")));
  }
  return take_sphere(sphere, place_of(*shape), spheres);
}

}  // namespace

std::string urdf_text(std::span<const Sphere> spheres, const std::string& name) {
  tinyxml2::XMLPrinter printer;
  printer.PushHeader(false, true);
  printer.OpenElement("robot");
  printer.PushAttribute("name", name.c_str());
  printer.OpenElement("link");
  printer.PushAttribute("name", name.c_str());
  for (const Sphere& sphere : spheres) {
    const std::string xyz = fmt::format("{} {} {}", sphere.center_m.x(), sphere.center_m.y(), sphere.center_m.z());
    printer.OpenElement("collision");
    printer.OpenElement("origin");
    printer.PushAttribute("xyz", xyz.c_str());
    printer.PushAttribute("rpy", "0 0 0");
    printer.CloseElement();
    printer.OpenElement("geometry");
    printer.OpenElement("sphere");
    printer.PushAttribute("radius", fmt::format("{}", sphere.radius_m).c_str());
    printer.CloseElement();
    printer.CloseElement();
    printer.CloseElement();
  }
  printer.CloseElement();
  printer.CloseElement();
  return printer.CStr();
}

Result<std::vector<Sphere>> urdf_spheres(const std::string& text, const SphereChoice& choice) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS) {
    return bad_input(fmt::format("line {}: not valid XML ({})", document.ErrorLineNum(), document.ErrorName()));
  }
  const XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) return bad_input("must be a URDF with a <robot>");
  std::vector<std::string> names;
  std::vector<const XMLElement*> links;
  for (const XMLElement* link = robot->FirstChildElement("link"); link != nullptr;
       link = link->NextSiblingElement("link")) {
    if (link->FirstChildElement("collision") == nullptr) continue;
    const char* name = link->Attribute("name");
    if (name == nullptr) return bad_input(place_of(*link) + ": must have a name");
    names.emplace_back(name);
    links.push_back(link);
  }
  const Result<std::string> chosen = chosen_link(names, choice.link);
  if (!chosen) return chosen.error();
  const XMLElement* link = links[static_cast<std::size_t>(std::ranges::find(names, chosen.value()) - names.begin())];
  std::vector<Sphere> spheres;
  for (const XMLElement* collision = link->FirstChildElement("collision"); collision != nullptr;
       collision = collision->NextSiblingElement("collision")) {
    const Status read = read_collision(*collision, spheres);
    if (!read) return read.error();
  }
  return spheres;
}

}  // namespace poise::geometry
