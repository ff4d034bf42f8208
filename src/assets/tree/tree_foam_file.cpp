// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "assets/json/json_document.h"
#include "assets/tree/tree_files.h"

namespace poise::geometry {
namespace {

using io::JsonValue;
using nlohmann::ordered_json;

ordered_json level_json(const SphereTree& tree, Level level) {
  const std::vector<NodeIndex> nodes = tree.nodes_at(level);
  const LevelErrors errors = level_errors(tree, nodes);
  ordered_json spheres = ordered_json::array();
  for (const NodeIndex node : nodes) {
    const Sphere sphere = tree.sphere(node);
    ordered_json item;
    item["origin"] = {sphere.center_m.x(), sphere.center_m.y(), sphere.center_m.z()};
    item["radius"] = sphere.radius_m;
    spheres.push_back(std::move(item));
  }
  ordered_json json;
  const bool known = protrusions_known(tree);
  const auto told = [known](double error_m) { return known ? ordered_json(error_m) : ordered_json(); };
  json["mean"] = told(errors.mean_m);
  json["best"] = told(errors.best_m);
  json["worst"] = told(errors.worst_m);
  json["spheres"] = std::move(spheres);
  return json;
}

Status read_sphere(const JsonValue& item, const std::string& place, std::vector<Sphere>& spheres) {
  const JsonValue* origin = item.find("origin");
  const JsonValue* radius = item.find("radius");
  if (origin == nullptr || radius == nullptr) return bad_input(place + ": must be a sphere with origin and radius");
  Sphere sphere;
  bool sound = origin->is_array() && origin->items().size() == 3;
  for (std::size_t i = 0; sound && i < 3; ++i) {
    sound = origin->items()[i].is_number();
    if (sound) sphere.center_m[static_cast<int>(i)] = origin->items()[i].number();
  }
  if (!sound) return bad_input(place + ".origin: must be a list of three numbers");
  if (!radius->is_number()) return bad_input(place + ".radius: must be a number");
  sphere.radius_m = radius->number();
  return take_sphere(sphere, place, spheres);
}

}  // namespace

std::string foam_text(const SphereTree& tree, Level level) {
  ordered_json levels = ordered_json::array();
  for (Level l = 0; l <= std::min(level, tree.depth()); ++l) levels.push_back(level_json(tree, l));
  return levels.dump(4) + "\n";
}

Result<std::vector<Sphere>> foam_spheres(const std::string& text, const SphereChoice& choice) {
  const Result<JsonValue> root = io::parse_json(text, "JSON");
  if (!root) return root.error();
  const JsonValue::Items levels = root.value().items();
  if (!root.value().is_array() || levels.empty()) return bad_input("must be a list of levels, each with its spheres");
  const std::size_t level = choice.level ? std::size_t{*choice.level} : levels.size() - 1;
  if (level >= levels.size())
    return bad_input(fmt::format("has no level {}, the deepest is {}", level, levels.size() - 1));
  const JsonValue* list = levels[level].find("spheres");
  if (list == nullptr || !list->is_array()) return bad_input(fmt::format("[{}]: must have a list of spheres", level));
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < list->items().size(); ++i) {
    const Status read = read_sphere(list->items()[i], fmt::format("[{}].spheres[{}]", level, i), spheres);
    if (!read) return read.error();
  }
  return spheres;
}

}  // namespace poise::geometry
