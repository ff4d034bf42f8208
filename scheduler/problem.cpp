// SPDX-License-Identifier: MIT
#include "poise/scheduler/problem.h"

#include <array>
#include <charconv>

namespace poise::scheduler {
namespace {

std::string number(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end.ptr};
}

}  // namespace

std::string text_of(const Problem& problem) {
  std::string text(problem.field);
  text += " = " + number(problem.value) + ", ";
  if (!problem.rule.empty()) return text.append(problem.rule);
  return text + "must be in [" + number(problem.least) + ", " + number(problem.most) + "]";
}

}  // namespace poise::scheduler
