// SPDX-License-Identifier: MIT
#include "sweep/run_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "scene/policy_file.h"

namespace poise::sweep {
namespace {

using Kind = io::JsonValue::Kind;

constexpr std::string_view kWeight = "weight.";

const RunSetting& weight_setting() {
  static const RunSetting weight{"weight", "--weight", SettingKind::Number};
  return weight;
}

std::string number_text(const io::JsonValue& value) {
  return value.is_unsigned() ? fmt::format("{}", value.magnitude()) : fmt::format("{}", value.number());
}

}  // namespace

const std::vector<RunSetting>& run_settings() {
  static const std::vector<RunSetting> all{
      {"frames", "--frames", SettingKind::Number},
      {"bodies", "--bodies", SettingKind::Number},
      {"warmup", "--warmup", SettingKind::Number},
      {"deadline_ms", "--deadline", SettingKind::Number},
      {"paced", "--paced", SettingKind::Flag},
      {"host_work_ms", "--host-work", SettingKind::Number},
      {"threads", "--threads", SettingKind::Number},
      {"policy", "--policy", SettingKind::Policy},
      {"contact", "--contact", SettingKind::Text},
      {"clock", "--clock", SettingKind::Text},
      {"budget_work", "--budget-work", SettingKind::Number},
      {"max_level", "--max-level", SettingKind::NumberOrText},
      {"backtracking", "--backtracking", SettingKind::Switch},
      {"sleeping", "--sleeping", SettingKind::Switch},
      {"islands_wait", "--islands-wait", SettingKind::Text},
      {"gaze", "--gaze", SettingKind::File},
      {"seed", "--seed", SettingKind::Number},
      {"executor", "--executor", SettingKind::Text},
      {"spin_us", "--spin", SettingKind::Number},
      {"realtime", "--realtime", SettingKind::Number},
      {"reference_every", "--reference", SettingKind::Number},
      {"alpha", "--alpha", SettingKind::Number},
      {"render_load_ms", "--render-load", SettingKind::NumberOrText},
      {"max_memory_mib", "--max-memory", SettingKind::Number},
  };
  return all;
}

const RunSetting* find_run_setting(std::string_view name) {
  if (name.starts_with(kWeight) && name.size() > kWeight.size()) return &weight_setting();
  const std::vector<RunSetting>& all = run_settings();
  const auto found = std::ranges::find(all, name, &RunSetting::name);
  return found == all.end() ? nullptr : &*found;
}

Result<Setting> read_setting(const RunSetting& setting, std::string_view name, const io::JsonValue& value) {
  const bool number = value.kind() == Kind::Number;
  const bool text = value.kind() == Kind::String;
  if (text && value.text().size() > kLongestSetting)
    return bad_input(fmt::format("must have at most {} bytes", kLongestSetting));
  switch (setting.kind) {
    case SettingKind::Number:
      if (number) return Setting{std::string(name), number_text(value), value.number()};
      return bad_input("must be a number");
    case SettingKind::Flag:
    case SettingKind::Switch:
      if (value.kind() != Kind::Boolean) return bad_input("must be true or false");
      return Setting{std::string(name), value.boolean() ? "true" : "false", {}};
    case SettingKind::NumberOrText:
      if (number) return Setting{std::string(name), number_text(value), value.number()};
      if (text && !value.text().empty()) return Setting{std::string(name), std::string(value.text()), {}};
      return bad_input("must be a number or a text");
    case SettingKind::Text:
    case SettingKind::Policy:
    case SettingKind::File:
      if (text && !value.text().empty()) return Setting{std::string(name), std::string(value.text()), {}};
      return bad_input("must be a text that is not empty");
  }
  return bad_input("must be a value");
}

std::string file_of(const Setting& setting, const std::string& base) {
  const RunSetting* known = find_run_setting(setting.name);
  if (known == nullptr) return {};
  const bool file =
      known->kind == SettingKind::File || (known->kind == SettingKind::Policy && io::names_policy_file(setting.text));
  return file ? (std::filesystem::path(base) / setting.text).lexically_normal().string() : std::string();
}

void add_words(const Setting& setting, const std::string& base, std::vector<std::string>& words) {
  const RunSetting* known = find_run_setting(setting.name);
  if (known == nullptr) return;
  if (known->kind == SettingKind::Flag) {
    if (setting.text == "true") words.emplace_back(known->option);
    return;
  }
  if (known->kind == SettingKind::Switch) {
    words.emplace_back(setting.text == "true" ? std::string(known->option)
                                              : fmt::format("--no-{}", known->option.substr(2)));
    return;
  }
  std::string value = file_of(setting, base);
  if (value.empty()) value = setting.text;
  if (setting.name == "reference_every") value = "every=" + value;
  if (known == &weight_setting()) value = setting.name.substr(kWeight.size()) + "=" + value;
  words.emplace_back(known->option);
  words.push_back(std::move(value));
}

}  // namespace poise::sweep
