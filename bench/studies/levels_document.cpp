// SPDX-License-Identifier: MIT
#include "studies/levels_document.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

Json level_json(simulation::ProbeLevel level) {
  return level.polygons ? Json("polygons") : Json(static_cast<int>(level.level));
}

Json pair_json(const LevelsPair& pair) {
  return {{"shape_a", pair.shape_a},
          {"shape_b", pair.shape_b},
          {"group", pair.group},
          {"touches", pair.touches},
          {"vertex_face", pair.vertex_face},
          {"edge_edge", pair.edge_edge},
          {"other_features", pair.other},
          {"throws_missed", pair.missed},
          {"throws_grazing", pair.grazing},
          {"throws_undecided", pair.undecided},
          {"dv_exact_mean_mps", pair.dv_mps},
          {"dw_exact_mean_mps", pair.dw_mps},
          {"oracle_uncertainty", pair.uncertainty},
          {"oracle_uncertainty_3mm", pair.uncertainty_three}};
}

Json row_json(const LevelsPair& pair, const LevelsRow& row) {
  return {{"shape_a", pair.shape_a},
          {"shape_b", pair.shape_b},
          {"model", row.model},
          {"level", level_json(row.level)},
          {"touches", pair.touches},
          {"dv_mean", row.dv.mean},
          {"dv_median", row.dv.median},
          {"dv_p90", row.dv.p90},
          {"dw_mean", row.dw.mean},
          {"dw_median", row.dw.median},
          {"dw_p90", row.dw.p90},
          {"toc_ms_mean", row.toc_ms_mean},
          {"toc_early_ms_mean", row.toc_early_ms_mean},
          {"late_share", row.late_share},
          {"unseen_share", row.unseen_share},
          {"ns_per_pair", row.cost.refine_ns},
          {"overlap_ns_per_pair", row.cost.overlap_ns},
          {"response_ns_per_pair", row.cost.response_ns},
          {"oracle_uncertainty", pair.uncertainty},
          {"oracle_uncertainty_3mm", pair.uncertainty_three}};
}

Json summary_json(const LevelsSummary& s) {
  return {{"group", s.group},
          {"model", s.model},
          {"level", level_json(s.level)},
          {"pairs", s.pairs},
          {"dv_mean", s.dv.mean},
          {"dv_median", s.dv.median},
          {"dv_p90", s.dv.p90},
          {"dw_mean", s.dw.mean},
          {"toc_ms_mean", s.toc_ms_mean},
          {"late_share", s.late_share},
          {"unseen_share", s.unseen_share},
          {"ns_per_pair", s.cost.refine_ns},
          {"overlap_ns_per_pair", s.cost.overlap_ns},
          {"response_ns_per_pair", s.cost.response_ns},
          {"dv_mean_to_reach", s.target ? Json(*s.target) : Json(nullptr)},
          {"reached", s.target ? Json(s.dv.mean <= *s.target) : Json(nullptr)}};
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

}  // namespace

std::string levels_json(const LevelsDocument& document) {
  Json json;
  json["schema"] = "poise.levels/2";
  json["half"] = document.half;
  json["seed"] = document.seed;
  json["touches"] = document.touches;
  json["depth"] = document.depth;
  json["fineness"] = document.fineness;
  json["speed_mps"] = document.speed_mps;
  json["spin_radps"] = document.spin_radps;
  json["restitution"] = document.restitution;
  json["dt_s"] = document.dt_s;
  json["threads"] = document.threads;
  json["rows"] = Json::array();
  for (const LevelsRow& row : document.rows) json["rows"].push_back(row_json(document.pairs[row.pair], row));
  json["pairs"] = Json::array();
  for (const LevelsPair& pair : document.pairs) json["pairs"].push_back(pair_json(pair));
  json["summary"] = Json::array();
  for (const LevelsSummary& s : summaries(document)) json["summary"].push_back(summary_json(s));
  json["setbacks"] = Json::array();
  for (const LevelsSetback& setback : setbacks(document)) {
    const LevelsRow& row = document.rows[setback.row];
    json["setbacks"].push_back({{"shape_a", document.pairs[row.pair].shape_a},
                                {"shape_b", document.pairs[row.pair].shape_b},
                                {"model", row.model},
                                {"level", level_json(row.level)},
                                {"dv_mean", row.dv.mean},
                                {"dv_mean_before", setback.before}});
  }
  json["machine"] = document.machine;
  json["build"] = document.build;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string levels_csv(const LevelsDocument& document) {
  std::string text =
      "shape_a,shape_b,group,model,level,touches,dv_mean,dv_median,dv_p90,dw_mean,dw_median,dw_p90,toc_ms_mean,toc_"
      "early_ms_mean,"
      "late_share,unseen_share,ns_per_pair,overlap_ns_per_pair,response_ns_per_pair,oracle_uncertainty,oracle_"
      "uncertainty_3mm\n";
  for (const LevelsRow& row : document.rows) {
    const LevelsPair& pair = document.pairs[row.pair];
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", quoted(pair.shape_a),
                        quoted(pair.shape_b), pair.group, row.model, level_name(row.level), pair.touches, row.dv.mean,
                        row.dv.median, row.dv.p90, row.dw.mean, row.dw.median, row.dw.p90, row.toc_ms_mean,
                        row.toc_early_ms_mean, row.late_share, row.unseen_share, row.cost.refine_ns,
                        row.cost.overlap_ns, row.cost.response_ns, pair.uncertainty, pair.uncertainty_three);
  }
  return text;
}

}  // namespace poise::io
