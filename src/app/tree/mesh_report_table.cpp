// SPDX-License-Identifier: MIT
#include "app/tree/mesh_report_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/files/output_files.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "poise/assets/mesh_file.h"
#include "poise/mesh.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

struct MeshFinding {
  std::string file;
  std::string kind;  ///< closed, open, sheet or refused
  std::string why;
  MeshReport mesh;  ///< of a mesh that is not refused
};

MeshFinding report_of(const std::string& file, const MeshReadOptions& reading) {
  const Result<TriangleMesh> mesh = read_mesh(file, reading);
  if (!mesh) {
    // The message begins with the file, which has a column of its own here.
    const std::string& message = mesh.error().message;
    const std::string name = file + ": ";
    return {file, "refused", message.starts_with(name) ? message.substr(name.size()) : message, {}};
  }
  Result<MeshReport> report = assess_mesh(mesh.value());
  if (!report) return {file, "refused", report.error().message, {}};
  const MeshReport& v = report.value();
  const char* const kind = v.solidity == Solidity::Shell ? "sheet" : v.edges.closed() ? "closed" : "open";
  return {file, kind, v.text, std::move(report).value()};
}

std::string as_json(const std::vector<MeshFinding>& reports) {
  nlohmann::ordered_json json;
  json["schema"] = "poise.mesh-reports/1";
  json["rows"] = nlohmann::ordered_json::array();
  for (const MeshFinding& v : reports) {
    nlohmann::ordered_json row = {{"file", v.file}, {"kind", v.kind}, {"why", v.why}};
    if (v.kind != "refused") {
      row["triangles"] = v.mesh.triangles;
      row["vertices"] = v.mesh.vertices;
      row["pieces"] = v.mesh.pieces;
      row["holes"] = v.mesh.holes;
      row["open_edges"] = v.mesh.edges.open_edges;
      row["inconsistent_edges"] = v.mesh.edges.inconsistent_edges;
      row["crowded_edges"] = v.mesh.edges.crowded_edges;
      row["area_m2"] = v.mesh.area_m2;
      row["volume_m3"] = v.mesh.volume_m3;
      row["volume_error_m3"] = v.mesh.volume_error_m3;
    }
    json["rows"].push_back(std::move(row));
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string as_table(const std::vector<MeshFinding>& reports) {
  std::size_t width = 4;
  for (const MeshFinding& v : reports) width = std::max(width, v.file.size());
  std::string text = fmt::format("{:<{}}  {:<8} why\n", "file", width, "kind");
  for (const MeshFinding& v : reports) text += fmt::format("{:<{}}  {:<8} {}\n", v.file, width, v.kind, v.why);
  return text;
}

}  // namespace

int print_mesh_reports(const TreeOptions& options) {
  MeshReadOptions reading;
  reading.scale = options.scale.value_or(1.0);
  if (const Status writable = can_write({options.json}); !writable) {
    print_error("poise tree: {}\n", writable.error().message);
    return exit_code_of(writable.error());
  }
  Progress progress(!options.quiet);
  std::vector<MeshFinding> reports;
  for (const std::string& file : options.meshes) {
    progress.say(fmt::format("mesh {} of {}: {}", reports.size() + 1, options.meshes.size(), file));
    reports.push_back(report_of(file, reading));
  }
  progress.end();
  Status written = Done{};
  if (!options.json.empty()) {
    const std::string text = as_json(reports);
    written = options.json == "-" ? io::write_stdout(text) : io::write_file(options.json, text);
  }
  if (!options.quiet && options.json != "-") add_failure(io::write_stdout(as_table(reports)), written);
  if (!written) return refuse("tree", written.error());
  const bool any = std::ranges::any_of(reports, [](const MeshFinding& v) { return v.kind != "refused"; });
  return any ? kExitDone : kExitBadInput;
}

}  // namespace poise::app
