// SPDX-License-Identifier: MIT
#include "app/tree/tree_document.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

Json levels_json(const MeasuredTree& tree, const TreeDocument& document) {
  Json levels = Json::array();
  for (const TreeLevelFigures& f : tree.levels) {
    levels.push_back({{"level", f.level},
                      {"spheres", f.spheres},
                      {"protrusion_max_m", f.protrusion_max_m},
                      {"protrusion_mean_m", f.protrusion_mean_m},
                      {"protrusion_bound_max_m", tree.cost ? Json(f.protrusion_bound_max_m) : Json(nullptr)},
                      {"protrusion_max_of_diagonal", f.protrusion_max_m / document.diagonal_m},
                      {"protrusion_mean_of_diagonal", f.protrusion_mean_m / document.diagonal_m},
                      {"surface_coverage", f.surface_coverage},
                      {"inside_coverage", f.inside_coverage},
                      {"volume_ratio", f.volume_ratio},
                      {"leaks", leaks(f, document.solidity)}});
  }
  return levels;
}

void add_tree(const MeasuredTree& tree, const TreeDocument& document, Json& json) {
  const bool built = tree.cost.has_value();
  json["tree"] = built ? Json("built") : Json(tree.file);
  json["depth"] = tree.depth;
  json["preset"] = built ? Json(preset_name(tree.preset)) : Json(nullptr);
  json["nodes"] = tree.nodes;
  json["bytes"] = tree.bytes;
  json["bytes_per_node"] = static_cast<double>(tree.bytes) / static_cast<double>(std::max<std::size_t>(tree.nodes, 1));
  json["build_ms"] = built ? Json(tree.cost->wall_ms) : Json(nullptr);
  json["build_cpu_ms"] = built ? Json(tree.cost->cpu_ms) : Json(nullptr);
  json["build_peak_bytes"] = built && tree.cost->peak_bytes > 0 ? Json(tree.cost->peak_bytes) : Json(nullptr);
  json["leaks"] = leaks(tree, document.solidity);
  json["levels"] = levels_json(tree, document);
}

}  // namespace

std::size_t bytes_of(const SphereTree& tree) {
  const auto of = [](const auto& array) { return array.size() * sizeof(array[0]); };
  return of(tree.x_m) + of(tree.y_m) + of(tree.z_m) + of(tree.radius_m) + of(tree.protrusion_max_m) +
         of(tree.protrusion_mean_m) + of(tree.fit) + of(tree.first_child) + of(tree.child_count) + of(tree.level_begin);
}

bool leaks(const TreeLevelFigures& figures, Solidity solidity) {
  return figures.surface_coverage < 1 || (solidity == Solidity::Solid && figures.inside_coverage < 1);
}

bool leaks(const MeasuredTree& tree, Solidity solidity) {
  return std::ranges::any_of(tree.levels, [&](const TreeLevelFigures& f) { return leaks(f, solidity); });
}

std::string preset_name(TreePreset preset) {
  return preset == TreePreset::Fast ? "fast" : preset == TreePreset::Best ? "best" : "default";
}

namespace {

Json document_json(const TreeDocument& document) {
  Json json;
  json["schema"] = "poise.tree/2";
  json["mesh"] = document.mesh;
  json["vertices"] = document.vertices;
  json["triangles"] = document.triangles;
  json["repair"] = {{"vertices_welded", document.repair.vertices_welded},
                    {"triangles_discarded", document.repair.triangles_discarded},
                    {"triangles_turned", document.repair.triangles_turned},
                    {"pieces_turned", document.repair.pieces_turned},
                    {"flipped", document.repair.flipped}};
  json["mesh_report"] = document.report;
  json["closed"] = document.closed;
  json["diagonal_m"] = document.diagonal_m;
  json["volume_m3"] = document.volume_m3;
  json["solidity"] = document.solidity == Solidity::Shell ? "shell" : "solid";
  json["seed"] = document.seed;
  json["threads"] = document.threads;
  json["samples"] = document.samples;
  if (!document.trees.empty()) add_tree(document.trees.front(), document, json);
  if (document.trees.size() > 1) {
    for (const MeasuredTree& tree : document.trees) {
      Json one;
      add_tree(tree, document, one);
      json["trees"].push_back(std::move(one));
    }
  }
  json["machine"] = document.machine;
  json["build"] = document.build;
  return json;
}

std::string as_text(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace

std::string tree_json(const TreeDocument& document) { return as_text(document_json(document)); }

std::string robot_json(const std::string& file, std::span<const RobotLink> links) {
  Json json;
  json["schema"] = "poise.robot-trees/1";
  json["robot"] = file;
  json["links"] = Json::array();
  for (const RobotLink& link : links) {
    Json row = {{"name", link.name}, {"shapes", link.shapes}};
    row["tree"] = link.tree ? document_json(*link.tree) : Json(nullptr);
    json["links"].push_back(std::move(row));
  }
  return as_text(json);
}

}  // namespace poise::io
