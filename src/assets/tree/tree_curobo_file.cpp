// SPDX-License-Identifier: MIT
#include <yaml-cpp/yaml.h>

#include <fmt/format.h>

#include "assets/tree/tree_files.h"

namespace poise::geometry {
namespace {

std::string place_of(const YAML::Node& node) {
  return node.Mark().is_null() ? std::string("the file") : fmt::format("line {}", node.Mark().line + 1);
}

bool read_scalar(const YAML::Node& node, double& value) { return node.IsScalar() && read_number(node.Scalar(), value); }

Status read_sphere(const YAML::Node& item, std::vector<Sphere>& spheres) {
  if (!item.IsMap() || !item["center"].IsDefined() || !item["radius"].IsDefined()) {
    return bad_input(place_of(item) + ": must be a sphere with center and radius");
  }
  const YAML::Node center = item["center"];
  Sphere sphere;
  bool sound = center.IsSequence() && center.size() == 3;
  for (std::size_t i = 0; sound && i < 3; ++i) sound = read_scalar(center[i], sphere.center_m[static_cast<int>(i)]);
  if (!sound) return bad_input(place_of(center) + ": center must be a list of three numbers");
  if (!read_scalar(item["radius"], sphere.radius_m))
    return bad_input(place_of(item["radius"]) + ": radius must be a number");
  return take_sphere(sphere, place_of(item), spheres);
}

/// The node `collision_spheres` of a file of spheres, or nested in a complete robot configuration.
YAML::Node spheres_node(const YAML::Node& root) {
  YAML::Node node;
  node.reset(root);
  for (const char* key : {"robot_cfg", "kinematics"}) {
    if (node.IsMap() && node[key].IsDefined()) node.reset(node[key]);
  }
  if (!node.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
  return node["collision_spheres"];
}

/// Always with a decimal point before an exponent: YAML 1.1, which Python reads, parses 1e-05 as text.
std::string yaml_number(double value) {
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
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
  try {
    const YAML::Node links = spheres_node(YAML::Load(text));
    if (!links.IsDefined() || !links.IsMap())
      return bad_input("must have collision_spheres with a list of spheres for each link");
    std::vector<std::string> names;
    for (const auto& link : links) {
      if (!link.first.IsScalar()) return bad_input(place_of(link.first) + ": must be the name of a link");
      if (link.second.IsSequence() && link.second.size() > 0) names.push_back(link.first.Scalar());
    }
    const Result<std::string> chosen = chosen_link(names, choice.link);
    if (!chosen) return chosen.error();
    std::vector<Sphere> spheres;
    for (const auto& link : links) {
      if (link.first.Scalar() != chosen.value() || !spheres.empty()) continue;
      for (const YAML::Node& item : link.second) {
        const Status read = read_sphere(item, spheres);
        if (!read) return read.error();
      }
    }
    return spheres;
  } catch (const YAML::Exception& failure) {
    return bad_input(fmt::format("line {}: not valid YAML: {}", failure.mark.line + 1, shown_text(failure.msg)));
  }
}

}  // namespace poise::geometry
