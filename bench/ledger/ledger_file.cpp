// SPDX-License-Identifier: MIT
#include "ledger/ledger_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

namespace poise::ledger {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "poise.ledger/1";
constexpr const char* kAbout =
    "Instructions that callgrind counts inside World::step, a frame and a unit of work, for the scenes of "
    "bench/ledger. Made by `bench_ledger --update REASON`; the test `ledger` fails when a number leaves the tolerance.";

/// Tenths for cheap units, whole instructions for expensive ones.
double rounded(double value) { return value < 1000 ? std::round(10 * value) / 10 : std::round(value); }

Json json_of(const std::vector<Cost>& costs, bool with_count) {
  Json json = Json::object();
  for (const Cost& cost : costs) {
    if (with_count)
      json[cost.name] = {{"instructions", rounded(cost.instructions)}, {"count", cost.count}};
    else
      json[cost.name] = rounded(cost.instructions);
  }
  return json;
}

EntryCosts entry_of(const std::string& name, const Json& json) {
  EntryCosts entry;
  entry.entry = name;
  const double frames = json.at("frames").get<double>();
  for (const auto& [cost, value] : json.at("per_frame").items())
    entry.per_frame.push_back({cost, value.get<double>(), frames});
  for (const auto& [cost, value] : json.at("per_unit").items())
    entry.per_unit.push_back({cost, value.at("instructions").get<double>(), value.at("count").get<double>()});
  return entry;
}

const Cost* find(const std::vector<Cost>& costs, const std::string& name) {
  const auto at = std::ranges::find(costs, name, &Cost::name);
  return at == costs.end() ? nullptr : &*at;
}

/// Compares two lists of costs of one entry.
class Comparison {
 public:
  Comparison(std::string entry, double tolerance, std::vector<Compared>& rows)
      : entry_(std::move(entry)), tolerance_(tolerance), rows_(rows) {}

  void costs(const std::vector<Cost>& before, const std::vector<Cost>& now) {
    for (const Cost& cost : now) {
      const Cost* old = find(before, cost.name);
      row(cost.name, old == nullptr ? 0 : old->instructions, cost.instructions);
      if (old != nullptr && !near(old->count, cost.count)) row(cost.name + " count", old->count, cost.count);
    }
    for (const Cost& cost : before) {
      if (find(now, cost.name) == nullptr) row(cost.name, cost.instructions, 0);
    }
  }

 private:
  [[nodiscard]] bool near(double before, double now) const {
    return before > 0 && std::abs(now - before) <= tolerance_ * before;
  }
  void row(const std::string& cost, double before, double now) {
    rows_.push_back({entry_, cost, before, now, near(before, now)});
  }

  std::string entry_;
  double tolerance_;
  std::vector<Compared>& rows_;
};

}  // namespace

Result<Ledger> read_ledger(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return bad_input(fmt::format("{}: cannot be read", file.string()));
  try {
    const Json json = Json::parse(stream);
    if (json.at("schema").get<std::string>() != kSchema)
      return bad_input(fmt::format("{}: schema must be {}", file.string(), kSchema));
    Ledger ledger;
    ledger.counted_by = json.at("counted_by").get<std::string>();
    ledger.compiler = json.at("compiler").get<std::string>();
    ledger.build = json.at("build").get<std::string>();
    ledger.tolerance = json.at("tolerance").get<double>();
    for (const Json& change : json.at("changes"))
      ledger.changes.push_back({change.at("commit").get<std::string>(), change.at("reason").get<std::string>()});
    for (const auto& [name, entry] : json.at("entries").items()) ledger.entries.push_back(entry_of(name, entry));
    if (!(ledger.tolerance > 0 && ledger.tolerance < 1))
      return bad_input(fmt::format("{}: tolerance = {}, must be in (0, 1)", file.string(), ledger.tolerance));
    return ledger;
  } catch (const Json::exception& error) {
    return bad_input(fmt::format("{}: {}", file.string(), error.what()));
  }
}

Status write_ledger(const Ledger& ledger, const std::filesystem::path& file) {
  Json json;
  json["schema"] = kSchema;
  json["about"] = kAbout;
  json["counted_by"] = ledger.counted_by;
  json["compiler"] = ledger.compiler;
  json["build"] = ledger.build;
  json["tolerance"] = ledger.tolerance;
  json["changes"] = Json::array();
  for (const LedgerChange& change : ledger.changes)
    json["changes"].push_back({{"commit", change.commit}, {"reason", change.reason}});
  json["entries"] = Json::object();
  for (const EntryCosts& entry : ledger.entries) {
    json["entries"][entry.entry] = {{"frames", entry.per_frame.front().count},
                                    {"per_frame", json_of(entry.per_frame, false)},
                                    {"per_unit", json_of(entry.per_unit, true)}};
  }
  std::ofstream stream(file, std::ios::binary);
  stream << json.dump(2) << '\n';
  stream.close();
  if (!stream) return Error{ErrorKind::OutputFailed, fmt::format("{}: cannot be written", file.string())};
  return Done{};
}

std::vector<Compared> compare(const Ledger& ledger, const std::vector<EntryCosts>& now) {
  std::vector<Compared> rows;
  const EntryCosts none;
  for (const EntryCosts& entry : now) {
    const auto at = std::ranges::find(ledger.entries, entry.entry, &EntryCosts::entry);
    const EntryCosts& before = at == ledger.entries.end() ? none : *at;
    Comparison comparison(entry.entry, ledger.tolerance, rows);
    comparison.costs(before.per_frame, entry.per_frame);
    comparison.costs(before.per_unit, entry.per_unit);
  }
  for (const EntryCosts& entry : ledger.entries) {
    if (std::ranges::find(now, entry.entry, &EntryCosts::entry) != now.end()) continue;
    Comparison comparison(entry.entry, ledger.tolerance, rows);
    comparison.costs(entry.per_frame, {});
    comparison.costs(entry.per_unit, {});
  }
  return rows;
}

}  // namespace poise::ledger
