// SPDX-License-Identifier: MIT
#include "scene/policy_file.h"

#include <fmt/format.h>

#include <charconv>

#include "scene/scene_parse.h"

namespace poise::io {
namespace {

constexpr std::string_view kPolicySchema = "poise.policy/1";

void parse_file(const JsonValue& root, Problems& problems, PolicyFile& file) {
  const ObjectReader top(root, "", problems, {"schema", "name", "policy", "evidence"});
  std::string schema;
  top.require("schema");
  top.text("schema", schema);
  if (const JsonValue* given = top.find("schema"); given != nullptr && schema != kPolicySchema)
    problems.refuse("schema", *given, fmt::format("must be \"{}\"", kPolicySchema));
  top.require("name");
  top.text("name", file.name);
  if (const JsonValue* given = top.find("name"); given != nullptr && file.name.empty())
    problems.refuse("name", *given, "must not be empty");
  const JsonValue* const evidence = top.find("evidence");
  if (evidence != nullptr && evidence->kind() != JsonValue::Kind::Object)
    problems.refuse("evidence", *evidence, "must be an object");
  if (const JsonValue* policy = top.require("policy")) parse_policy(*policy, problems, file.policy);
}

}  // namespace

bool names_policy_file(std::string_view text) {
  return text.find('/') != std::string_view::npos || text.ends_with(".json");
}

Result<PolicyFile> read_policy_file(const std::filesystem::path& file, const scheduler::Policy& base,
                                    std::vector<std::string>* errors) {
  if (errors != nullptr) errors->clear();
  const auto refused = [errors](const Error& error) {
    if (errors != nullptr) errors->push_back(error.message);
    return error;
  };
  const Result<std::string> text = read_scene_text(file);
  if (!text) return refused(text.error());
  const Result<JsonValue> root = parse_json(text.value(), file.string());
  if (!root) return refused(root.error());
  PolicyFile read{{}, base};
  Problems problems(file.string());
  parse_file(root.value(), problems, read);
  if (problems.count() == 0) return read;
  if (errors != nullptr) *errors = problems.all();
  return *problems.first();
}

Status set_weight(std::string_view text, scheduler::Policy& policy) {
  std::vector<std::string_view> names;
  for (const scheduler::PolicyField& field : scheduler::policy_weights()) names.push_back(field.name);
  const std::size_t at = text.find('=');
  const std::string_view name = text.substr(0, at);
  for (const scheduler::PolicyField& field : scheduler::policy_weights()) {
    if (at == std::string_view::npos || field.name != name) continue;
    const std::string_view given = text.substr(at + 1);
    double value = 0;
    const auto [stop, failure] = std::from_chars(given.data(), given.data() + given.size(), value);
    const bool read = failure == std::errc{} && stop == given.data() + given.size();
    if (!read || !(value >= field.least && value <= field.most))
      return bad_input(
          fmt::format("{} = {}, must be from {:g} to {:g}", name, printable(given), field.least, field.most));
    policy.*field.value = value;
    return Done{};
  }
  return bad_input(fmt::format("{}, must be CUE=VALUE with a CUE of {}", in_quotes(text), listed(names)));
}

}  // namespace poise::io
