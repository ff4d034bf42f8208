// SPDX-License-Identifier: MIT
#include "sweep/trial_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>

#include "assets/files/text_file.h"
#include "assets/json/json_document.h"
#include "scene/result_file.h"

namespace poise::sweep {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostOutcomeBytes = 1U << 20U;
constexpr std::uint64_t kMostLogBytes = 1U << 26U;
constexpr std::size_t kLongestLine = 300;
constexpr std::array kStates{TrialState::Pending, TrialState::Done, TrialState::Failed, TrialState::TimedOut};

Error failed(const fs::path& file, const std::error_code& reason) {
  return {ErrorKind::OutputFailed, fmt::format("{}: cannot be written: {}", file.string(), reason.message())};
}

double number_of(const io::JsonValue& object, std::string_view key) {
  const io::JsonValue* found = object.find(key);
  return found == nullptr ? 0 : found->number();
}

/// A file that somebody else wrote may say any number.
int whole_of(double number) {
  constexpr double kMost = std::numeric_limits<int>::max();
  return static_cast<int>(std::clamp(number, -kMost, kMost));
}

std::string text_of(const io::JsonValue& object, std::string_view key) {
  const io::JsonValue* found = object.find(key);
  return found == nullptr || !found->is_string() ? std::string() : std::string(found->text());
}

std::string outcome_json(const Trial& trial, const Outcome& outcome) {
  nlohmann::ordered_json settings = nlohmann::ordered_json::object();
  for (const Setting& setting : trial.settings) settings[setting.name] = setting.text;
  const nlohmann::ordered_json json{
      {"schema", "poise.trial/1"},      {"key", trial.key},           {"scene", trial.scene},
      {"settings", settings},           {"repeat", trial.repeat},     {"state", state_name(outcome.state)},
      {"exit_code", outcome.exit_code}, {"seconds", outcome.seconds}, {"time_limit_s", outcome.time_limit_s},
      {"host", outcome.host},           {"engine", outcome.engine},   {"affinity", outcome.affinity}};
  return json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

const char* state_name(TrialState state) {
  switch (state) {
    case TrialState::Pending:
      return "pending";
    case TrialState::Done:
      return "done";
    case TrialState::Failed:
      return "failed";
    case TrialState::TimedOut:
      return "timed_out";
  }
  return "pending";
}

Status TrialStore::make() const {
  for (const char* name : {"trials", "logs", "work"}) {
    std::error_code failure;
    fs::create_directories(folder_ / name, failure);
    if (failure) return failed(folder_ / name, failure);
  }
  return Done{};
}

fs::path TrialStore::result_file(const std::string& key) const { return folder_ / "trials" / (key + ".json"); }
fs::path TrialStore::outcome_file(const std::string& key) const { return folder_ / "trials" / (key + ".trial.json"); }
fs::path TrialStore::log_file(const std::string& key) const { return folder_ / "logs" / (key + ".log"); }
fs::path TrialStore::work_file(const std::string& key, const std::string& writer) const {
  return folder_ / "work" / fmt::format("{}.{}.json", key, writer);
}

Outcome parse_outcome(std::string_view text) {
  Outcome outcome;
  const Result<io::JsonValue> json = io::parse_json(text, "outcome");
  if (!json) return outcome;
  const std::string state = text_of(json.value(), "state");
  for (const TrialState known : kStates) {
    if (state == state_name(known)) outcome.state = known;
  }
  outcome.exit_code = whole_of(number_of(json.value(), "exit_code"));
  outcome.seconds = number_of(json.value(), "seconds");
  outcome.time_limit_s = number_of(json.value(), "time_limit_s");
  outcome.host = text_of(json.value(), "host");
  outcome.engine = text_of(json.value(), "engine");
  if (const io::JsonValue* affinity = json.value().find("affinity"); affinity != nullptr && affinity->is_array()) {
    for (std::size_t i = 0; i < affinity->items().size(); ++i)
      outcome.affinity.push_back(whole_of(affinity->items()[i].number()));
  }
  return outcome;
}

Outcome TrialStore::outcome_of(const Trial& trial) const {
  std::error_code none;
  if (!fs::exists(outcome_file(trial.key), none)) return {};
  const Result<std::string> text = geometry::read_bytes(outcome_file(trial.key), kMostOutcomeBytes);
  if (!text) return {};
  const Outcome outcome = parse_outcome(text.value());
  const bool lost = outcome.state == TrialState::Done && !fs::exists(result_file(trial.key), none);
  const bool longer = outcome.state == TrialState::TimedOut && outcome.time_limit_s < trial.time_limit_s;
  return lost || longer ? Outcome{} : outcome;
}

Status TrialStore::store(const Trial& trial, const Outcome& outcome, const fs::path& work_file) const {
  // The outcome first: without its result it counts as nothing.
  const Status written = io::write_file(outcome_file(trial.key), outcome_json(trial, outcome));
  if (!written || outcome.state != TrialState::Done) return written;
  std::error_code failure;
  fs::rename(work_file, result_file(trial.key), failure);
  if (failure) return failed(result_file(trial.key), failure);
  return Done{};
}

void TrialStore::clear_work() const {
  std::error_code failure;
  std::vector<fs::path> left;
  for (fs::directory_iterator entry(folder_ / "work", failure), end; !failure && entry != end; entry.increment(failure))
    left.push_back(entry->path());
  for (const fs::path& file : left) fs::remove(file, failure);
}

void TrialStore::forget(const std::string& key) const {
  std::error_code none;
  fs::remove(outcome_file(key), none);
  fs::remove(result_file(key), none);
}

std::vector<std::string> log_tail(const fs::path& file, std::size_t most) {
  std::vector<std::string> lines;
  const Result<std::string> text = geometry::read_bytes(file, kMostLogBytes);
  if (!text) return lines;
  std::size_t begin = 0;
  while (begin < text.value().size()) {
    const std::size_t end = std::min(text.value().find('\n', begin), text.value().size());
    if (end > begin) lines.push_back(io::printable(text.value().substr(begin, std::min(end - begin, kLongestLine))));
    begin = end + 1;
  }
  if (lines.size() > most) lines.erase(lines.begin(), lines.end() - static_cast<std::ptrdiff_t>(most));
  return lines;
}

}  // namespace poise::sweep
