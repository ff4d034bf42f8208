// SPDX-License-Identifier: MIT
#include "scene/compare/comparison_document.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scene/csv_text.h"

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }
std::string optional_text(const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; }
std::string shown(const std::optional<double>& value, double factor = 1) {
  return value ? fmt::format("{:.3g}", factor * *value) : "-";
}
std::string end_of(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

}  // namespace

std::string comparison_json(const ComparisonDocument& d) {
  Json json;
  json["schema"] = "poise.compare/1";
  json["scene"] = d.scene;
  json["bodies"] = d.bodies;
  json["clock"] = d.clock;
  json["budget_unit"] = d.budget_unit;
  json["history"] = d.history;
  json["seed"] = d.seed;
  json["machine"] = d.machine;
  json["build"] = d.build;
  json["frames"] = d.result.frames;
  json["not_converged"] = d.result.not_converged;
  json["undefined"] = d.result.undefined;
  json["rows"] = Json::array();
  for (const ComparisonRow& row : d.result.rows) {
    json["rows"].push_back({{"scene", d.scene},
                            {"policy", row.policy},
                            {"budget", row.budget},
                            {"budget_unit", d.budget_unit},
                            {"frames", d.result.frames},
                            {"E", row.e_mps.mean},
                            {"E_low", optional_json(row.e_mps.low)},
                            {"E_high", optional_json(row.e_mps.high)},
                            {"E_rel", row.e_rel.mean},
                            {"E_rel_low", optional_json(row.e_rel.low)},
                            {"E_rel_high", optional_json(row.e_rel.high)},
                            {"E_seen", row.e_seen_mps.mean},
                            {"E_seen_low", optional_json(row.e_seen_mps.low)},
                            {"E_seen_high", optional_json(row.e_seen_mps.high)},
                            {"regret", optional_json(row.regret_mps)},
                            {"gap_px", optional_json(row.gap_mean_px)},
                            {"false_rate", optional_json(row.false_rate)},
                            {"work_units", row.work_units},
                            {"step_ms", row.time_ms}});
  }
  json["areas"] = Json::array();
  for (const ComparisonArea& area : d.result.areas) {
    json["areas"].push_back({{"policy", area.policy},
                             {"E_seen", area.e_seen_mps.mean},
                             {"E_seen_low", optional_json(area.e_seen_mps.low)},
                             {"E_seen_high", optional_json(area.e_seen_mps.high)},
                             {"regret", optional_json(area.regret_mps)}});
  }
  json["conclusion"] = d.result.conclusion;
  return json.dump(2) + "\n";
}

std::string comparison_csv(const ComparisonDocument& d) {
  std::string text =
      "scene,policy,budget,budget_unit,frames,E,E_low,E_high,E_rel,E_rel_low,E_rel_high,E_seen,E_seen_low,E_seen_high,"
      "regret,gap_px,false_rate,"
      "work_units,step_ms\n";
  for (const ComparisonRow& row : d.result.rows) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_text(d.scene),
                        csv_text(row.policy), row.budget, d.budget_unit, d.result.frames, row.e_mps.mean,
                        optional_text(row.e_mps.low), optional_text(row.e_mps.high), row.e_rel.mean,
                        optional_text(row.e_rel.low), optional_text(row.e_rel.high), row.e_seen_mps.mean,
                        optional_text(row.e_seen_mps.low), optional_text(row.e_seen_mps.high),
                        optional_text(row.regret_mps), optional_text(row.gap_mean_px), optional_text(row.false_rate),
                        row.work_units, row.time_ms);
  }
  return text;
}

std::string comparison_table(const ComparisonDocument& d) {
  std::string text = fmt::format("{}: {} bodies, {} frames compared", d.scene, d.bodies, d.result.frames);
  if (d.result.not_converged > 0)
    text += fmt::format("; {} left out: their references did not converge", d.result.not_converged);
  if (d.result.undefined > 0) text += fmt::format("; {} left out: nothing touched", d.result.undefined);
  text +=
      fmt::format("\n\n{:<13} {:>10} {:>9} {:>9} {:>9} {:>19} {:>9} {:>7} {:>7} {:>9} {:>8}\n", "policy", d.budget_unit,
                  "E, m/s", "E_rel", "E_seen", "95 % interval", "regret", "gap, px", "false %", "units", "step, ms");
  for (const ComparisonRow& row : d.result.rows) {
    text += fmt::format("{:<13} {:>10g} {:>9.4g} {:>9.3g} {:>9.4g} {:>9} {:>9} {:>9} {:>7} {:>7} {:>9.0f} {:>8.3g}\n",
                        row.policy, row.budget, row.e_mps.mean, row.e_rel.mean, row.e_seen_mps.mean,
                        end_of(row.e_seen_mps.low), end_of(row.e_seen_mps.high), shown(row.regret_mps),
                        shown(row.gap_mean_px), shown(row.false_rate, 100), row.work_units, row.time_ms);
  }
  if (d.result.budgets.size() > 1) {
    text += "\nmean over the budgets\n";
    for (const ComparisonArea& area : d.result.areas) {
      text += fmt::format("{:<13} {:>10} {:>9} {:>9} {:>9.4g} {:>9} {:>9} {:>9}\n", area.policy, "", "", "",
                          area.e_seen_mps.mean, end_of(area.e_seen_mps.low), end_of(area.e_seen_mps.high),
                          shown(area.regret_mps));
    }
  }
  return text + "\n" + d.result.conclusion + "\n";
}

}  // namespace poise::io
