// SPDX-License-Identifier: MIT
#include "app/options/suggestions.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "scene/field_reader.h"

namespace poise::app {
namespace {

/// A command line may be long; the first slips are told, of the first words that are looked at. Chosen.
constexpr std::size_t kMostHints = 8;
constexpr std::size_t kMostWords = 64;

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::string nearest(const std::string& word, const std::vector<std::string>& names) {
  const std::vector<std::string_view> views(names.begin(), names.end());
  return std::string(io::nearest_name(word, views));
}

}  // namespace

std::string argument_hints(const CLI::App& app) {
  const CLI::App* command = &app;
  std::string called = app.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    called += " " + command->get_name();
  }
  std::string hints;
  std::size_t told = 0;
  std::size_t seen = 0;
  bool first = true;
  for (const std::string& word : app.remaining(true)) {
    if (++seen > kMostWords || told == kMostHints) break;
    const bool option = word.size() > 2 && word.starts_with("--");
    std::string near;
    if (option) {
      near = nearest(word.substr(0, word.find('=')), options_of(*command));
    } else if (first) {
      near = nearest(word, commands_of(*command));
    }
    first = false;
    if (near.empty()) continue;
    ++told;
    hints += fmt::format("{}: did you mean {} instead of {}?\n", called, near, io::printable(word.substr(0, 40)));
  }
  return hints;
}

CLI::Validator one_of(std::vector<std::string_view> names) {
  std::string shown = "{";
  for (const std::string_view name : names) shown += (shown.size() > 1 ? "," : "") + std::string(name);
  const auto check = [names = std::move(names)](std::string& text) -> std::string {
    if (std::find(names.begin(), names.end(), std::string_view(text)) != names.end()) return {};
    return fmt::format("{} must be {}{}", io::in_quotes(text), io::listed(names), io::suggestion(text, names));
  };
  return {check, shown + "}", "one of"};
}

}  // namespace poise::app
