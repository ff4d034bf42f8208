// SPDX-License-Identifier: MIT
#include "studies/callgrind_output.h"

#include <algorithm>
#include <charconv>

namespace poise::app {
namespace {

bool begins(std::string_view text, std::string_view with) { return text.substr(0, with.size()) == with; }

}  // namespace

Result<Counted> read_callgrind(std::string_view text) {
  Counted counted;
  bool total = false;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    // A name is given once, as `fn=(7) name` for a caller or `cfn=(7) name` for a callee, and by number afterwards.
    if (begins(line, "fn=") || begins(line, "cfn=")) {
      const std::size_t name = line.find(") ");
      if (name != std::string_view::npos) counted.functions.emplace_back(line.substr(name + 2));
    } else if (begins(line, "totals:") || begins(line, "summary:")) {
      std::string_view number = line.substr(line.find(':') + 1);
      number.remove_prefix(std::min(number.find_first_not_of(' '), number.size()));
      total = std::from_chars(number.data(), number.data() + number.size(), counted.instructions).ec == std::errc{};
    }
  }
  if (!total || counted.functions.empty())
    return bad_input("valgrind wrote no profile that tells functions and a total");
  return counted;
}

std::vector<std::string> with_any(const std::vector<std::string>& functions, const std::vector<std::string>& parts) {
  std::vector<std::string> found;
  for (const std::string& function : functions) {
    if (std::ranges::any_of(parts, [&](const std::string& part) { return function.find(part) != std::string::npos; }))
      found.push_back(function);
  }
  return found;
}

}  // namespace poise::app
