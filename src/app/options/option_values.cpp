// SPDX-License-Identifier: MIT
#include "app/options/option_values.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>

namespace poise::app {
namespace {

template <class T>
bool parse_whole_text(const std::string& text, T& value) {
  const char* const end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), end, value);
  return failure == std::errc{} && stop == end;
}

}  // namespace

CLI::Option* add_whole(CLI::App& app, const std::string& name, std::optional<std::uint64_t>& target, std::uint64_t min,
                       std::uint64_t max, const std::string& help) {
  const auto read = [&target, name, min, max](const std::string& text) {
    std::uint64_t value = 0;
    if (!parse_whole_text(text, value) || value < min || value > max) {
      throw CLI::ValidationError(fmt::format("{} = {}, must be a whole number from {} to {}", name, text, min, max),
                                 CLI::ExitCodes::ValidationError);
    }
    target = value;
  };
  return app.add_option_function<std::string>(name, read, help)->type_name("N");
}

CLI::Option* add_number(CLI::App& app, const std::string& name, std::optional<double>& target, double min,
                        bool open_min, double max, const std::string& help) {
  const auto read = [&target, name, min, open_min, max](const std::string& text) {
    double value = 0;
    const bool parsed = parse_whole_text(text, value) && std::isfinite(value);
    if (!parsed || (open_min ? value <= min : value < min) || value > max) {
      throw CLI::ValidationError(
          fmt::format("{} = {}, must be a number {} {:g} and <= {:g}", name, text, open_min ? ">" : ">=", min, max),
          CLI::ExitCodes::ValidationError);
    }
    target = value;
  };
  return app.add_option_function<std::string>(name, read, help)->type_name("MS");
}

void add_switch(CLI::App& app, const std::string& name, std::optional<bool>& target, const std::string& help) {
  CLI::Option* const on = app.add_flag_function(
                                 "--" + name, [&target](std::int64_t) { target = true; }, help)
                              ->take_last();
  app.add_flag_function("--no-" + name, [&target](std::int64_t) { target = false; })->take_last()->excludes(on);
}

CLI::Validator numbers_within(double min, double max) {
  return {[min, max](const std::string& text) {
            double value = 0;
            if (parse_whole_text(text, value) && std::isfinite(value) && value >= min && value <= max)
              return std::string();
            return fmt::format("{}, must be a number >= {:g} and <= {:g}", text, min, max);
          },
          fmt::format("{:g} to {:g}", min, max)};
}

CLI::Option* add_every(CLI::App& app, const std::string& name, std::optional<std::uint64_t>& target, std::uint64_t max,
                       const std::string& help) {
  const auto read = [&target, name, max](const std::string& text) {
    const std::string start = "every=";
    std::uint64_t value = 0;
    const bool named = text.compare(0, start.size(), start) == 0;
    if (!named || !parse_whole_text(text.substr(start.size()), value) || value < 1 || value > max) {
      throw CLI::ValidationError(
          fmt::format("{} = {}, must be every=K with a whole number K from 1 to {}", name, text, max),
          CLI::ExitCodes::ValidationError);
    }
    target = value;
  };
  return app.add_option_function<std::string>(name, read, help)->type_name("every=K");
}

CLI::Option* add_text(CLI::App& app, const std::string& name, std::string& target, const std::string& help) {
  const auto not_empty = [](const std::string& text) { return text.empty() ? "must not be empty" : ""; };
  return app.add_option(name, target, help)->check(not_empty);
}

CLI::Option* add_path(CLI::App& app, const std::string& name, std::string& target, const std::string& help) {
  return add_text(app, name, target, help)->type_name("FILE");
}

CLI::Option* add_scene(CLI::App& app, std::string& target) {
  return app
      .add_option("scene", target,
                  "A scene file, the name of a scene that ships (poise scenes), or - for the standard input")
      ->required()
      ->type_name("SCENE");
}

}  // namespace poise::app
