// SPDX-License-Identifier: MIT
#include <yaml-cpp/yaml.h>

#include <fmt/format.h>

#include "assets/json/json_value.h"
#include "assets/tree/tree_files.h"
#include "assets/tree/yaml_value.h"

namespace poise::geometry {
namespace {

using io::JsonValue;

bool read_scalar(const JsonValue& value, double& number) {
  return value.is_string() && read_number(value.text(), number);
}

Status read_yaml_sphere(const JsonValue& item, const std::string& place, std::vector<Sphere>& spheres) {
  const JsonValue* center = item.find("center");
  const JsonValue* radius = item.find("radius");
  if (center == nullptr || radius == nullptr) return bad_input(place + ": must be a sphere with center and radius");
  Sphere sphere;
  bool sound = center->is_array() && center->items().size() == 3;
  for (std::size_t i = 0; sound && i < 3; ++i)
    sound = read_scalar(center->items()[i], sphere.center_m[static_cast<int>(i)]);
  if (!sound) return bad_input(place + ": center must be a list of three numbers");
  if (!read_scalar(*radius, sphere.radius_m)) return bad_input(place + ": radius must be a number");
  return take_sphere(sphere, place, spheres);
}

/// `collision_spheres` of a file of spheres, or nested in a complete robot configuration.
const JsonValue* links_of(const JsonValue& root) {
  const JsonValue* node = &root;
  for (const char* key : {"robot_cfg", "kinematics"}) {
    const JsonValue* inner = node->find(key);
    if (inner != nullptr) node = inner;
  }
  return node->find("collision_spheres");
}

/// Always with a decimal point before an exponent: YAML 1.1, which Python reads, parses 1e-05 as text.
std::string yaml_number(double value) {
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

Result<std::vector<Sphere>> spheres_of(const JsonValue& root, const SphereChoice& choice) {
  const JsonValue* links = links_of(root);
  if (links == nullptr || !links->is_object())
    return bad_input("must have collision_spheres with a list of spheres for each link");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < links->items().size(); ++i) {
    if (!links->items()[i].items().empty() && links->items()[i].is_array()) names.emplace_back(links->keys()[i]);
  }
  const Result<std::string> chosen = chosen_link(names, choice.link);
  if (!chosen) return chosen.error();
  const JsonValue::Items list = links->find(chosen.value())->items();
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string place = fmt::format("collision_spheres.{}[{}]", shown_text(chosen.value()), i);
    const Status read = read_yaml_sphere(list[i], place, spheres);
    if (!read) return read.error();
  }
  return spheres;
}

}  // namespace

std::string curobo_text(std::span<const Sphere> spheres, const std::string& name) {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "collision_spheres" << YAML::Value << YAML::BeginMap;
  // Always quoted, so that a link called "on" or "1e3" is not read as a boolean or a number.
  out << YAML::Key << YAML::DoubleQuoted << name << YAML::Value << YAML::BeginSeq;
  for (const Sphere& sphere : spheres) {
    out << YAML::BeginMap << YAML::Key << "center" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (int i = 0; i < 3; ++i) out << yaml_number(sphere.center_m[i]);
    out << YAML::EndSeq << YAML::Key << "radius" << YAML::Value << yaml_number(sphere.radius_m) << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

Result<std::vector<Sphere>> curobo_spheres(const std::string& text, const SphereChoice& choice) {
  const Result<YamlDocument> document = parse_yaml(text);
  if (!document) return document.error();
  Result<std::vector<Sphere>> spheres = spheres_of(document.value().root, choice);
  if (spheres || document.value().alias_line == 0) return spheres;
  return bad_input(fmt::format("{}; aliases are not followed, and line {} has one: must be written out",
                               spheres.error().message, document.value().alias_line));
}

}  // namespace poise::geometry
