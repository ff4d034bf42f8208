// SPDX-License-Identifier: MIT
#include "studies/trees_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

/// A row as the cells of a table, beginning with the name; the row of a refused mesh has two cells.
using Cells = std::vector<std::string>;

std::size_t most_levels(const TreesDocument& document) {
  std::size_t most = 0;
  for (const TreesRow& row : document.rows) most = std::max(most, row.tree.levels.size());
  return most;
}

Cells header_of(const TreesDocument& document) {
  Cells cells{"mesh", "triangles", "preset", "CPU s", "MiB", "nodes"};
  for (std::size_t level = 1; level < most_levels(document); ++level) cells.push_back(fmt::format("level {}", level));
  cells.emplace_back("covered %");
  return cells;
}

Cells cells_of(const TreesRow& row, std::size_t levels) {
  if (!row.refusal.empty()) return {row.mesh, row.refusal};
  const TreeBuildCost cost = row.tree.cost.value_or(TreeBuildCost{});
  Cells cells{row.mesh,
              std::to_string(row.triangles),
              preset_name(row.tree.preset),
              fmt::format("{:.2f}", cost.cpu_ms / 1000),
              fmt::format("{:.0f}", static_cast<double>(cost.peak_bytes) / (1U << 20U)),
              std::to_string(row.tree.nodes)};
  double covered = 1;
  for (const TreeLevelFigures& f : row.tree.levels) {
    covered = std::min(covered, f.surface_coverage);
    if (row.solidity == Solidity::Solid) covered = std::min(covered, f.inside_coverage);
    if (f.level == 0) continue;
    cells.push_back(fmt::format("{:.2f} / {:.2f} / {:.3f}", 100 * f.protrusion_max_m / row.diagonal_m,
                                100 * f.protrusion_mean_m / row.diagonal_m, f.volume_ratio));
  }
  cells.resize(6 + std::max<std::size_t>(levels, 1) - 1);
  cells.push_back(fmt::format("{:.4f}", 100 * covered));
  return cells;
}

std::vector<Cells> all_cells(const TreesDocument& document) {
  std::vector<Cells> rows{header_of(document)};
  for (const TreesRow& row : document.rows) rows.push_back(cells_of(row, most_levels(document)));
  return rows;
}

std::string made_by(const TreesDocument& d) {
  return fmt::format("{} samples a figure, seed {}; {}, {} cores, {}; poise {} commit {}, {}", d.samples, d.seed,
                     d.machine.processor, d.machine.cores, d.machine.system, d.build.version, d.build.commit,
                     d.build.compiler);
}

Json level_json(const TreeLevelFigures& f, double diagonal_m) {
  return {{"level", f.level},
          {"spheres", f.spheres},
          {"protrusion_max_of_diagonal", f.protrusion_max_m / diagonal_m},
          {"protrusion_mean_of_diagonal", f.protrusion_mean_m / diagonal_m},
          {"volume_ratio", f.volume_ratio},
          {"surface_coverage", f.surface_coverage},
          {"inside_coverage", f.inside_coverage}};
}

Json row_json(const TreesRow& row) {
  Json json = {{"mesh", row.mesh}, {"file", row.file.empty() ? Json(nullptr) : Json(row.file)}};
  if (!row.refusal.empty()) {
    json["refused"] = row.refusal;
    return json;
  }
  const TreeBuildCost cost = row.tree.cost.value_or(TreeBuildCost{});
  json["triangles"] = row.triangles;
  json["diagonal_m"] = row.diagonal_m;
  json["solidity"] = row.solidity == Solidity::Shell ? "shell" : "solid";
  json["preset"] = preset_name(row.tree.preset);
  json["depth"] = row.tree.depth;
  json["cpu_s"] = cost.cpu_ms / 1000;
  json["wall_s"] = cost.wall_ms / 1000;
  json["peak_bytes"] = cost.peak_bytes;
  json["nodes"] = row.tree.nodes;
  json["levels"] = Json::array();
  for (const TreeLevelFigures& f : row.tree.levels) json["levels"].push_back(level_json(f, row.diagonal_m));
  return json;
}

TreeLevelFigures level_of(const Json& json) {
  TreeLevelFigures f;
  f.level = json.at("level").get<Level>();
  f.spheres = json.at("spheres").get<std::size_t>();
  f.protrusion_max_m = json.at("protrusion_max_m").get<double>();
  f.protrusion_mean_m = json.at("protrusion_mean_m").get<double>();
  f.surface_coverage = json.at("surface_coverage").get<double>();
  f.inside_coverage = json.at("inside_coverage").get<double>();
  f.volume_ratio = json.at("volume_ratio").get<double>();
  return f;
}

std::string quoted_cell(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

}  // namespace

Result<TreesRow> row_of_tree_json(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != "poise.tree/2") return bad_input("schema: must be poise.tree/2");
    TreesRow row;
    row.file = json.at("mesh").get<std::string>();
    row.triangles = json.at("triangles").get<std::size_t>();
    row.diagonal_m = json.at("diagonal_m").get<double>();
    row.solidity = json.at("solidity") == "shell" ? Solidity::Shell : Solidity::Solid;
    row.tree.depth = json.at("depth").get<Level>();
    const auto preset = json.at("preset").get<std::string>();
    row.tree.preset = preset == "fast" ? TreePreset::Fast : preset == "best" ? TreePreset::Best : TreePreset::Default;
    row.tree.nodes = json.at("nodes").get<std::size_t>();
    row.tree.bytes = json.at("bytes").get<std::size_t>();
    const Json& peak = json.at("build_peak_bytes");
    row.tree.cost = TreeBuildCost{json.at("build_ms").get<double>(), json.at("build_cpu_ms").get<double>(),
                                  peak.is_null() ? 0 : peak.get<std::uint64_t>()};
    for (const Json& level : json.at("levels")) row.tree.levels.push_back(level_of(level));
    return row;
  } catch (const Json::exception& failure) {
    return bad_input(fmt::format("not a poise.tree/2 document: {}", failure.what()));
  }
}

std::string trees_json(const TreesDocument& document) {
  Json json;
  json["schema"] = "poise.trees/1";
  json["study"] = document.study;
  json["samples"] = document.samples;
  json["seed"] = document.seed;
  json["threads"] = document.threads;
  json["rows"] = Json::array();
  for (const TreesRow& row : document.rows) json["rows"].push_back(row_json(row));
  json["machine"] = document.machine;
  json["build"] = document.build;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string trees_table(const TreesDocument& document) {
  const std::vector<Cells> rows = all_cells(document);
  std::vector<std::size_t> widths;
  for (const Cells& row : rows) {
    if (row.size() == 2 && rows[0].size() > 2) {  // a refusal spans the columns
      widths[0] = std::max(widths[0], row[0].size());
      continue;
    }
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const Cells& row : rows) {
    std::string line = fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i < row.size(); ++i)
      line += row.size() == 2 ? "  " + row[i] : fmt::format("  {:>{}}", row[i], widths[i]);
    text += line + "\n";
  }
  return text +
         "\nLevels: largest / mean protrusion in % of the diagonal / volume of the balls over that of the mesh.\n" +
         made_by(document) + "\n";
}

std::string trees_markdown(const TreesDocument& document) {
  std::string text;
  bool head = true;
  for (const Cells& row : all_cells(document)) {
    text += "| " + fmt::format("{}", fmt::join(row, " | ")) + " |\n";
    if (head) {
      for (std::size_t i = 0; i < row.size(); ++i) text += "|---";
      text += "|\n";
    }
    head = false;
  }
  return text + "\n" + made_by(document) + ".\n";
}

std::string trees_csv(const TreesDocument& document) {
  std::string text =
      "mesh,triangles,preset,depth,cpu_s,wall_s,peak_bytes,nodes,level,spheres,protrusion_max_percent,protrusion_mean_"
      "percent,"
      "volume_ratio,surface_coverage,inside_coverage\n";
  for (const TreesRow& row : document.rows) {
    const TreeBuildCost cost = row.tree.cost.value_or(TreeBuildCost{});
    for (const TreeLevelFigures& f : row.tree.levels) {
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", quoted_cell(row.mesh), row.triangles,
                          preset_name(row.tree.preset), row.tree.depth, cost.cpu_ms / 1000, cost.wall_ms / 1000,
                          cost.peak_bytes, row.tree.nodes, f.level, f.spheres,
                          100 * f.protrusion_max_m / row.diagonal_m, 100 * f.protrusion_mean_m / row.diagonal_m,
                          f.volume_ratio, f.surface_coverage, f.inside_coverage);
    }
  }
  return text;
}

}  // namespace poise::io
