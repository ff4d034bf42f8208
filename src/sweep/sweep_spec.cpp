// SPDX-License-Identifier: MIT
#include "sweep/sweep_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "scene/run/requirement.h"
#include "scene/run/run_document.h"
#include "scene/scene_parse.h"

namespace poise::sweep {
namespace {

using io::JsonValue;
using io::ObjectReader;
using io::Problems;

constexpr std::string_view kSpecSchema = "poise.sweep/1";
constexpr std::uint64_t kMostRepeats = 10'000;
constexpr std::uint64_t kMostCores = 256;
constexpr double kLongestTrial_s = 30 * 24 * 3600.0;

/// A list of texts without empty ones and without repetitions; `least` of them.
void read_texts(const ObjectReader& top, std::string_view key, std::size_t least, std::vector<std::string>& target) {
  const JsonValue* value = top.find(key);
  if (value == nullptr) return;
  Problems& problems = top.problems();
  const std::string path = top.path(key);
  if (!value->is_array() || value->items().size() < least) {
    problems.refuse(path, *value, least > 0 ? "must be a list of texts that is not empty" : "must be a list of texts");
    return;
  }
  std::set<std::string_view> seen;
  for (std::size_t i = 0; i < value->items().size(); ++i) {
    const JsonValue& item = value->items()[i];
    const std::string_view text = item.is_string() ? item.text() : std::string_view();
    if (text.empty()) {
      problems.refuse(io::item_path(path, i), item, "must be a text that is not empty");
    } else if (text.size() > kLongestSetting) {
      problems.refuse(io::item_path(path, i), item, fmt::format("must have at most {} bytes", kLongestSetting));
    } else if (!seen.insert(text).second) {
      problems.refuse(io::item_path(path, i), item, "is given twice");
    } else {
      target.emplace_back(text);
    }
  }
}

/// The run setting `name` of a specification, or a problem at `path`.
const RunSetting* known_setting(const std::string& path, std::string_view name, Problems& problems) {
  const RunSetting* known = find_run_setting(name);
  if (known != nullptr) return known;
  std::vector<std::string_view> names;
  for (const RunSetting& setting : run_settings()) names.push_back(setting.name);
  problems.refuse(path, "no such setting of a run" + problems.suggest(name, names));
  return nullptr;
}

void refuse_count(const std::string& path, std::size_t count, Problems& problems) {
  problems.refuse(path, fmt::format("{} settings, must be at most {} with all axes", count, kMostSettings));
}

void read_settings(const ObjectReader& top, SweepSpec& spec) {
  const JsonValue* value = top.find("settings");
  if (value == nullptr) return;
  Problems& problems = top.problems();
  if (!value->is_object()) return problems.refuse(top.path("settings"), *value, "must be an object");
  if (value->keys().size() > kMostSettings) return refuse_count(top.path("settings"), value->keys().size(), problems);
  for (std::size_t i = 0; i < value->keys().size(); ++i) {
    const std::string_view name = value->keys()[i];
    const std::string path = io::member_path(top.path("settings"), name);
    const RunSetting* known = known_setting(path, name, problems);
    if (known == nullptr) continue;
    const Result<Setting> setting = read_setting(*known, name, value->items()[i]);
    if (setting) {
      spec.settings.push_back(setting.value());
    } else {
      problems.refuse(path, value->items()[i], setting.error().message);
    }
  }
}

/// The values of one axis.
void read_axis(const std::string& path, std::string_view name, const JsonValue& list, Problems& problems,
               SweepSpec& spec) {
  const RunSetting* known = known_setting(path, name, problems);
  if (known == nullptr) return;
  if (!list.is_array() || list.items().empty())
    return problems.refuse(path, list, "must be a list of values that is not empty");
  const auto named = [&](const auto& other) { return other.name == name; };
  if (std::ranges::any_of(spec.settings, named))
    return problems.refuse(path, "is in settings too; a setting has one value or is an axis");
  if (std::ranges::any_of(spec.axes, named)) return problems.refuse(path, "is given twice: `seeds` is the axis `seed`");
  Axis axis{std::string(name), {}};
  std::set<std::string> seen;
  for (std::size_t i = 0; i < list.items().size(); ++i) {
    const std::string at = io::item_path(path, i);
    const Result<Setting> setting = read_setting(*known, name, list.items()[i]);
    if (!setting) {
      problems.refuse(at, list.items()[i], setting.error().message);
    } else if (!seen.insert(setting.value().text).second) {
      problems.refuse(at, list.items()[i], "is given twice");
    } else {
      axis.values.push_back(setting.value());
    }
  }
  if (!axis.values.empty()) spec.axes.push_back(std::move(axis));
}

void read_axes(const ObjectReader& top, SweepSpec& spec) {
  Problems& problems = top.problems();
  if (const JsonValue* value = top.find("axes"); value != nullptr) {
    if (!value->is_object()) return problems.refuse(top.path("axes"), *value, "must be an object");
    if (value->keys().size() + spec.settings.size() > kMostSettings)
      return refuse_count(top.path("axes"), value->keys().size() + spec.settings.size(), problems);
    for (std::size_t i = 0; i < value->keys().size(); ++i)
      read_axis(io::member_path(top.path("axes"), value->keys()[i]), value->keys()[i], value->items()[i], problems,
                spec);
  }
  if (const JsonValue* seeds = top.find("seeds"); seeds != nullptr)
    read_axis(top.path("seeds"), "seed", *seeds, problems, spec);
}

void check_figure(const std::string& path, const std::string& name, Problems& problems) {
  static const std::vector<std::string> known = figure_names();
  if (std::ranges::find(known, name) != known.end()) return;
  const std::vector<std::string_view> names(known.begin(), known.end());
  problems.refuse(path,
                  fmt::format("{}, no such figure of a run{}", io::in_quotes(name), problems.suggest(name, names)));
}

void check_requirements(const ObjectReader& top, const SweepSpec& spec) {
  for (std::size_t i = 0; i < spec.requirements.size(); ++i) {
    const std::string path = io::item_path(top.path("requirements"), i);
    const Result<io::Requirement> parsed = io::parse_requirement(spec.requirements[i]);
    if (!parsed) {
      top.problems().refuse(path, parsed.error().message);
      continue;
    }
    for (const io::Comparison& comparison : parsed.value()) {
      if (!comparison.left.name.empty()) check_figure(path, comparison.left.name, top.problems());
      if (!comparison.right.name.empty()) check_figure(path, comparison.right.name, top.problems());
    }
  }
  for (std::size_t i = 0; i < spec.figures.size(); ++i)
    check_figure(io::item_path(top.path("figures"), i), spec.figures[i], top.problems());
}

void check_frontier_axis(const ObjectReader& frontier, std::string_view key, const std::string& name,
                         const SweepSpec& spec) {
  const JsonValue* given = frontier.find(key);
  if (given == nullptr || !given->is_string()) return;
  const auto axis = std::ranges::find(spec.axes, name, &Axis::name);
  if (axis == spec.axes.end() || name == "seed") {
    frontier.problems().refuse(frontier.path(key), *given, "must be the name of an axis other than seed");
  } else if (!std::ranges::all_of(axis->values, [](const Setting& value) { return value.number.has_value(); })) {
    frontier.problems().refuse(frontier.path(key), *given, "must be an axis of numbers");
  }
}

void read_frontier(const ObjectReader& top, SweepSpec& spec) {
  const JsonValue* value = top.find("frontier");
  if (value == nullptr) return;
  const ObjectReader reader(*value, top.path("frontier"), top.problems(), {"largest", "against"});
  Frontier frontier;
  reader.require_text("largest", frontier.largest);
  reader.require_text("against", frontier.against);
  check_frontier_axis(reader, "largest", frontier.largest, spec);
  check_frontier_axis(reader, "against", frontier.against, spec);
  if (!frontier.largest.empty() && frontier.largest == frontier.against)
    top.problems().refuse(reader.path("against"), "must be another axis than `largest`");
  if (!top.has("requirements"))
    top.problems().refuse(top.path("frontier"), "needs `requirements`: they say where the frontier is");
  spec.frontier = frontier;
}

void read_trial_needs(const ObjectReader& top, SweepSpec& spec) {
  const JsonValue* value = top.find("trial");
  if (value == nullptr) return;
  const ObjectReader reader(*value, top.path("trial"), top.problems(), {"cores", "time_limit_s"});
  std::uint64_t cores = 0;
  reader.whole("cores", 1, kMostCores, cores);
  if (cores > 0) spec.cores = cores;
  reader.number("time_limit_s", {0, kLongestTrial_s, true}, spec.time_limit_s);
}

void check_count(const ObjectReader& top, const SweepSpec& spec) {
  // Each factor is at most the number of bytes of the file; the product of doubles overflows to infinity at worst.
  double trials = static_cast<double>(spec.scenes.size()) * static_cast<double>(spec.repeats);
  for (const Axis& axis : spec.axes) trials *= static_cast<double>(axis.values.size());
  if (trials > static_cast<double>(kMostTrials))
    top.problems().refuse("", fmt::format("{:.0f} trials, must be at most {}", trials, kMostTrials));
}

void read_top(const JsonValue& root, Problems& problems, SweepSpec& spec) {
  const ObjectReader top(root, "", problems,
                         {"schema", "name", "description", "scenes", "settings", "axes", "seeds", "repeats",
                          "requirements", "frontier", "figures", "trial"});
  if (!root.is_object()) return;
  std::string schema, description;
  top.require_text("schema", schema);
  if (const JsonValue* given = top.find("schema"); given != nullptr && given->is_string() && schema != kSpecSchema)
    problems.refuse("schema", *given, fmt::format("must be \"{}\"", kSpecSchema));
  top.text("name", spec.name);
  if (const JsonValue* given = top.find("name"); given != nullptr && spec.name.empty())
    problems.refuse("name", *given, "must not be empty");
  top.text("description", description);
  top.require("scenes");
  read_texts(top, "scenes", 1, spec.scenes);
  read_settings(top, spec);
  read_axes(top, spec);
  top.whole("repeats", 1, kMostRepeats, spec.repeats);
  read_texts(top, "requirements", 0, spec.requirements);
  read_texts(top, "figures", 0, spec.figures);
  check_requirements(top, spec);
  read_frontier(top, spec);
  read_trial_needs(top, spec);
  check_count(top, spec);
}

}  // namespace

std::vector<std::string> figure_names() {
  io::RunDocument document;
  document.figures = simulation::run_figures({}, {true, document.alpha});
  std::vector<std::string> names;
  for (const io::NamedFigure& figure : io::named_figures(document)) names.push_back(figure.name);
  return names;
}

Result<SweepSpec> parse_spec(std::string_view text, const std::string& name, const std::filesystem::path& base,
                             std::vector<std::string>& errors) {
  errors.clear();
  const Result<JsonValue> root = io::parse_json(text, name);
  if (!root) {
    errors.push_back(root.error().message);
    return root.error();
  }
  SweepSpec spec;
  spec.name = std::filesystem::path(name).stem().string();
  spec.source = name;
  spec.base = base.empty() ? "." : base.string();
  Problems problems(name);
  read_top(root.value(), problems, spec);
  if (problems.count() == 0) return spec;
  errors = problems.all();
  return *problems.first();
}

Result<SweepSpec> read_spec(const std::filesystem::path& file, std::vector<std::string>& errors) {
  const Result<std::string> text = io::read_scene_text(file);
  if (!text) {
    errors.assign(1, text.error().message);
    return text.error();
  }
  return parse_spec(text.value(), file.string(), file.parent_path(), errors);
}

}  // namespace poise::sweep
