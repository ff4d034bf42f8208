// SPDX-License-Identifier: MIT
#include "sweep/trial_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "assets/files/text_file.h"
#include "scene/field_reader.h"
#include "sweep/sweep_spec.h"

namespace poise::sweep {
namespace {

using io::JsonValue;
using io::ObjectReader;
using io::Problems;
using Json = nlohmann::ordered_json;

constexpr std::string_view kBatchSchema = "poise.sweep-batch/1";
constexpr std::uint64_t kMostBatchBytes = std::uint64_t{1} << 30U;
constexpr std::uint64_t kMany = std::numeric_limits<std::uint64_t>::max();

Json json_of(const Trial& trial) {
  Json settings = Json::array();
  for (const Setting& setting : trial.settings) settings.push_back({{"name", setting.name}, {"text", setting.text}});
  return {{"key", trial.key},
          {"label", trial.label},
          {"scene", trial.scene},
          {"scene_file", trial.scene_file},
          {"scene_hash", trial.scene_hash},
          {"settings", settings},
          {"repeat", trial.repeat},
          {"cores", trial.cores},
          {"timed", trial.timed},
          {"time_limit_s", trial.time_limit_s},
          {"base", trial.base}};
}

void read_trial_settings(const ObjectReader& reader, Trial& trial) {
  const JsonValue* list = reader.require("settings");
  if (list == nullptr) return;
  if (!list->is_array()) return reader.problems().refuse(reader.path("settings"), *list, "must be a list");
  for (std::size_t i = 0; i < list->items().size(); ++i) {
    const ObjectReader item(list->items()[i], io::item_path(reader.path("settings"), i), reader.problems(),
                            {"name", "text"});
    Setting setting;
    item.require_text("name", setting.name);
    item.require_text("text", setting.text);
    if (find_run_setting(setting.name) == nullptr)
      reader.problems().refuse(item.path("name"), "no such setting of a run");
    trial.settings.push_back(std::move(setting));
  }
}

Trial read_trial(const JsonValue& value, const std::string& path, Problems& problems) {
  const ObjectReader reader(value, path, problems,
                            {"key", "label", "scene", "scene_file", "scene_hash", "settings", "repeat", "cores",
                             "timed", "time_limit_s", "base"});
  Trial trial;
  reader.require_text("key", trial.key);
  reader.require_text("label", trial.label);
  reader.require_text("scene", trial.scene);
  reader.require_text("scene_file", trial.scene_file);
  reader.require_text("scene_hash", trial.scene_hash);
  read_trial_settings(reader, trial);
  reader.require_whole("repeat", 1, kMany, trial.repeat);
  reader.require_whole("cores", 1, kMany, trial.cores);
  reader.require_flag("timed", trial.timed);
  reader.require_number("time_limit_s", io::kPositive, trial.time_limit_s);
  reader.require_text("base", trial.base);
  // It becomes the name of files.
  const bool digits = trial.key.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (reader.has("key") && (trial.key.size() != 32 || !digits))
    problems.refuse(reader.path("key"), "must be 32 hexadecimal digits");
  return trial;
}

}  // namespace

std::vector<Trial> TrialBatch::of_task(std::uint64_t task) const {
  const std::size_t begin = task >= tasks() ? trials.size() : static_cast<std::size_t>(task * per_task);
  const std::size_t end = std::min(trials.size(), begin + static_cast<std::size_t>(per_task));
  return {trials.begin() + static_cast<std::ptrdiff_t>(begin), trials.begin() + static_cast<std::ptrdiff_t>(end)};
}

std::string batch_json(const TrialBatch& batch) {
  Json trials = Json::array();
  for (const Trial& trial : batch.trials) trials.push_back(json_of(trial));
  const Json json{
      {"schema", kBatchSchema}, {"per_task", batch.per_task}, {"exclusive", batch.exclusive}, {"trials", trials}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<TrialBatch> read_batch(const std::filesystem::path& file) {
  const Result<std::string> text = geometry::read_text_file(file, kMostBatchBytes);
  if (!text) return text.error();
  return parse_batch(text.value(), file.string());
}

Result<TrialBatch> parse_batch(std::string_view text, const std::string& name) {
  const Result<JsonValue> root = io::parse_json(text, name);
  if (!root) return root.error();
  Problems problems(name);
  const ObjectReader top(root.value(), "", problems, {"schema", "per_task", "exclusive", "trials"});
  TrialBatch batch;
  std::string schema;
  top.require_text("schema", schema);
  if (!schema.empty() && schema != kBatchSchema) problems.refuse("schema", fmt::format("must be \"{}\"", kBatchSchema));
  top.require_whole("per_task", 1, kMostTrials, batch.per_task);
  top.require_flag("exclusive", batch.exclusive);
  const JsonValue* trials = top.require("trials");
  if (trials != nullptr && !trials->is_array()) problems.refuse("trials", *trials, "must be a list");
  if (trials != nullptr && trials->is_array()) {
    // One that is refused takes many times what it is written with.
    for (std::size_t i = 0; i < trials->items().size(); ++i) {
      Trial trial = read_trial(trials->items()[i], io::item_path("trials", i), problems);
      if (problems.count() == 0) batch.trials.push_back(std::move(trial));
    }
  }
  if (const auto first = problems.first()) return *first;
  return batch;
}

std::uint64_t trials_per_task(std::size_t trials, std::uint64_t most_tasks) {
  const std::uint64_t most = std::max<std::uint64_t>(1, most_tasks);
  return std::max<std::uint64_t>(1, (trials + most - 1) / most);
}

}  // namespace poise::sweep
