// SPDX-License-Identifier: MIT
#include "ledger/callgrind_profile.h"

#include <charconv>
#include <optional>

namespace poise::ledger {
namespace {

/// The second number of a line: the position is first, then the cost.
std::optional<std::uint64_t> cost_of(std::string_view line) {
  const std::size_t space = line.find(' ');
  if (space == std::string_view::npos) return std::nullopt;
  std::uint64_t cost = 0;
  const char* end = line.data() + line.size();
  if (std::from_chars(line.data() + space + 1, end, cost).ec != std::errc{}) return std::nullopt;
  return cost;
}

bool is_cost_line(std::string_view line) {
  return !line.empty() && (line[0] == '+' || line[0] == '-' || line[0] == '*' || (line[0] >= '0' && line[0] <= '9'));
}

/// Whether the text after a function's name is its argument list, and not the name of a lambda inside it.
bool is_whole_function(std::string_view rest) {
  if (rest.empty()) return true;
  if (rest[0] != '(') return false;
  int depth = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    depth += rest[i] == '(' ? 1 : rest[i] == ')' ? -1 : 0;
    if (depth == 0) return rest.find("::", i) == std::string_view::npos;
  }
  return false;
}

}  // namespace

Result<CallgrindProfile> parse_callgrind_profile(std::string_view text) {
  CallgrindProfile profile;
  std::uint64_t* function = nullptr;
  std::string_view name;
  // The next cost is that of a part of the function which the compiler has made a function of: it is counted there.
  bool of_part = false;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.starts_with("fn=")) {
      name = line.substr(3);
      function = &profile.inclusive[std::string(name)];
    } else if (line.starts_with("cfn=")) {
      const std::string_view called = line.substr(4);
      of_part = called.starts_with(name) && called.substr(name.size()).starts_with(" [clone .part");
    } else if (line.starts_with("totals: ")) {
      profile.total = cost_of(line).value_or(0);
    } else if (function != nullptr && is_cost_line(line)) {
      // The function's own instructions, or after `calls=` those of the called function.
      if (!of_part) *function += cost_of(line).value_or(0);
      of_part = false;
    }
  }
  if (profile.total == 0 || profile.inclusive.empty())
    return bad_input("callgrind wrote no profile with functions and a total");
  return profile;
}

std::uint64_t instructions_inside(const CallgrindProfile& profile, std::string_view name) {
  std::uint64_t sum = 0;
  for (auto at = profile.inclusive.lower_bound(name); at != profile.inclusive.end(); ++at) {
    if (!std::string_view(at->first).starts_with(name)) break;
    if (is_whole_function(std::string_view(at->first).substr(name.size()))) sum += at->second;
  }
  return sum;
}

}  // namespace poise::ledger
