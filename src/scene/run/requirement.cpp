// SPDX-License-Identifier: MIT
#include "scene/run/requirement.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include "assets/json/json_document.h"
#include "scene/field_reader.h"

namespace poise::io {
namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\n");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\n") - begin + 1);
}

bool is_name(std::string_view text) {
  if (text.empty() || !((text[0] >= 'a' && text[0] <= 'z') || (text[0] >= 'A' && text[0] <= 'Z') || text[0] == '_'))
    return false;
  constexpr std::string_view kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-";
  return text.find_first_not_of(kAllowed) == std::string_view::npos;
}

Result<Operand> parse_operand(std::string_view text) {
  Operand operand;
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  const std::string_view digits = plus ? text.substr(1) : text;
  const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), operand.number);
  if (failure == std::errc{} && end == digits.data() + digits.size() && std::isfinite(operand.number)) return operand;
  if (failure == std::errc::result_out_of_range) return bad_input(fmt::format("{} is out of range", in_quotes(text)));
  if (!is_name(text) || text == "nan" || text == "inf" || text == "infinity") {
    return bad_input(fmt::format("{} must be a name or a number", in_quotes(text)));
  }
  operand.name = text;
  return operand;
}

struct RelationName {
  std::string_view text;
  Relation relation;
};
// Two-character names come first, so that <= is not parsed as <.
constexpr std::array<RelationName, 6> kRelations{{{"<=", Relation::AtMost},
                                                  {">=", Relation::AtLeast},
                                                  {"==", Relation::Equal},
                                                  {"!=", Relation::Unequal},
                                                  {"<", Relation::Less},
                                                  {">", Relation::Greater}}};

Result<Comparison> parse_comparison(std::string_view text) {
  const std::size_t at = text.find_first_of("<>=!");
  const RelationName* found = nullptr;
  for (const RelationName& candidate : kRelations) {
    if (found == nullptr && at != std::string_view::npos && text.substr(at, candidate.text.size()) == candidate.text) {
      found = &candidate;
    }
  }
  if (found == nullptr) {
    return bad_input(
        fmt::format("{} must be a comparison by one of < <= > >= == !=, such as miss_rate < 0.01", in_quotes(text)));
  }
  Result<Operand> left = parse_operand(trimmed(text.substr(0, at)));
  if (!left) return left.error();
  Result<Operand> right = parse_operand(trimmed(text.substr(at + found->text.size())));
  if (!right) return right.error();
  return Comparison{std::move(left).value(), std::move(right).value(), found->relation, printable(text)};
}

const NamedFigure* find_figure(const std::string& name, std::span<const NamedFigure> figures) {
  for (const NamedFigure& figure : figures) {
    if (figure.name == name) return &figure;
  }
  return nullptr;
}

std::optional<double> value_of(const Operand& operand, std::span<const NamedFigure> figures) {
  if (operand.name.empty()) return operand.number;
  const NamedFigure* figure = find_figure(operand.name, figures);
  return figure == nullptr ? std::nullopt : figure->value;
}

bool holds(double left, Relation relation, double right) {
  switch (relation) {
    case Relation::Less:
      return left < right;
    case Relation::AtMost:
      return left <= right;
    case Relation::Greater:
      return left > right;
    case Relation::AtLeast:
      return left >= right;
    case Relation::Equal:
      return left == right;
    case Relation::Unequal:
      return left != right;
  }
  return false;
}

}  // namespace

Result<Requirement> parse_requirement(std::string_view text) {
  Requirement requirement;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find("&&", begin);
    const std::string_view part = trimmed(text.substr(begin, end == std::string_view::npos ? end : end - begin));
    if (part.empty()) return bad_input("a comparison is missing");
    Result<Comparison> comparison = parse_comparison(part);
    if (!comparison) return comparison.error();
    requirement.push_back(std::move(comparison).value());
    if (end == std::string_view::npos) return requirement;
    begin = end + 2;
  }
}

Status check_names(const Requirement& requirement, std::span<const NamedFigure> figures) {
  std::vector<std::string_view> names;
  for (const NamedFigure& figure : figures) names.emplace_back(figure.name);
  for (const Comparison& comparison : requirement) {
    for (const Operand* operand : {&comparison.left, &comparison.right}) {
      if (!operand->name.empty() && find_figure(operand->name, figures) == nullptr) {
        return bad_input(fmt::format("no figure of a run is called {}{}", in_quotes(operand->name),
                                     suggestion(operand->name, names)));
      }
    }
  }
  return Done{};
}

std::vector<std::string> failed_comparisons(const Requirement& requirement, std::span<const NamedFigure> figures) {
  std::vector<std::string> failed;
  for (const Comparison& comparison : requirement) {
    const std::optional<double> left = value_of(comparison.left, figures);
    const std::optional<double> right = value_of(comparison.right, figures);
    if (left && right && holds(*left, comparison.relation, *right)) continue;
    std::string sentence = comparison.text + " does not hold";
    const char* separator = ": ";
    for (const Operand* operand : {&comparison.left, &comparison.right}) {
      if (operand->name.empty()) continue;
      const std::optional<double> value = operand == &comparison.left ? left : right;
      sentence += value ? fmt::format("{}{} = {}", separator, operand->name, *value)
                        : fmt::format("{}{} is not defined for this run", separator, operand->name);
      separator = ", ";
    }
    failed.push_back(std::move(sentence));
  }
  return failed;
}

}  // namespace poise::io
