// SPDX-License-Identifier: MIT
#include "scene/run/time_priors.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "assets/cache/tree_cache_folder.h"
#include "assets/json/json_document.h"

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kMostBytes = 1U << 16U;
constexpr const char* kSchema = "poise.times/2";
/// Longer than any cost that a run can learn; a larger number is damaged data.
constexpr double kMostUs = 1e9;

std::string text_of(const TimePriorsKey& key) {
  return fmt::format("{}; {} cores, {} threads, {}, {}, alpha {}", key.machine, key.cores, key.threads, key.executor,
                     key.contact, key.alpha);
}

bool read_list(const JsonValue* json, scheduler::TailForecast::Features& into) {
  if (json == nullptr || !json->is_array() || json->items().size() != into.size()) return false;
  for (std::size_t i = 0; i < into.size(); ++i) {
    if (!json->items()[i].is_number()) return false;
    into[i] = json->items()[i].number();
    if (!std::isfinite(into[i]) || into[i] < 0 || into[i] > kMostUs) return false;
  }
  return true;
}

bool read_number(const JsonValue& json, const char* name, double least, double most, double& into) {
  const JsonValue* const at = json.find(name);
  if (at == nullptr || !at->is_number()) return false;
  into = at->number();
  return std::isfinite(into) && into >= least && into <= most;
}

bool is_text(const JsonValue* json, std::string_view text) {
  return json != nullptr && json->is_string() && json->text() == text;
}

}  // namespace

std::filesystem::path time_priors_file(const std::filesystem::path& folder, const TimePriorsKey& key) {
  const std::string text = text_of(key);
  return folder / fmt::format("times-{:016x}.json", XXH3_64bits(text.data(), text.size()));
}

std::optional<scheduler::TimePriors> read_time_priors(const std::filesystem::path& folder, const TimePriorsKey& key) {
  std::string bytes;
  if (geometry::read_entry(time_priors_file(folder, key), kMostBytes, bytes) != geometry::EntryRead::Found)
    return std::nullopt;
  return parse_time_priors(bytes, key);
}

std::optional<scheduler::TimePriors> parse_time_priors(std::string_view text, const TimePriorsKey& key) {
  const Result<JsonValue> read = parse_json(text, "times");
  if (!read) return std::nullopt;
  const JsonValue& json = read.value();
  if (!is_text(json.find("schema"), kSchema) || !is_text(json.find("key"), text_of(key))) return std::nullopt;
  scheduler::TimePriors priors;
  double frames = 0;
  const bool sound = read_list(json.find("tail_us"), priors.tail_us) &&
                     read_list(json.find("head_us"), priors.head_us) &&
                     read_number(json, "log_quantile", scheduler::TrackedQuantile::kLow,
                                 scheduler::TrackedQuantile::kHigh, priors.log_quantile) &&
                     read_number(json, "spread", 0,
                                 scheduler::TrackedQuantile::kHigh - scheduler::TrackedQuantile::kLow, priors.spread) &&
                     read_number(json, "unit_cost_ns", 0, kMostUs, priors.unit_cost_ns) &&
                     read_number(json, "frames", 1, 1e15, frames);
  if (!sound) return std::nullopt;
  priors.frames = static_cast<std::uint64_t>(frames);
  return priors;
}

bool write_time_priors(const std::filesystem::path& folder, const TimePriorsKey& key,
                       const scheduler::TimePriors& priors) {
  if (folder.empty() || priors.frames == 0) return false;
  const Json json = {{"schema", kSchema},
                     {"key", text_of(key)},
                     {"tail_us", priors.tail_us},
                     {"head_us", priors.head_us},
                     {"log_quantile", priors.log_quantile},
                     {"spread", priors.spread},
                     {"unit_cost_ns", priors.unit_cost_ns},
                     {"frames", priors.frames}};
  return geometry::write_entry(time_priors_file(folder, key), json.dump(2) + "\n");
}

}  // namespace poise::io
