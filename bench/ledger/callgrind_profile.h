// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "poise/result.h"

namespace poise::ledger {

/// Instructions that a run under valgrind's callgrind executed while it collected.
struct CallgrindProfile {
  std::uint64_t total = 0;
  /// By demangled name: instructions of the function and of everything it called but its own compiler-made parts, which
  /// have entries of theirs. Inner calls of a recursive function are counted again.
  std::map<std::string, std::uint64_t, std::less<>> inclusive;
};

/// Reads callgrind's format, version 1, written with --compress-strings=no --compress-pos=no. Refused: a text without a
/// total or without functions.
Result<CallgrindProfile> parse_callgrind_profile(std::string_view text);

/// Instructions inside all functions with this name, for any arguments, and inside their compiler-made parts
/// (`name(...) [clone .part.0]`), which callers enter directly; 0 if there is none.
std::uint64_t instructions_inside(const CallgrindProfile& profile, std::string_view name);

}  // namespace poise::ledger
