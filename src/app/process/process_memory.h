// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>

namespace poise::app {

/// Lets the count of the largest resident memory start again from what is resident now, where the system can (Linux,
/// proc(5)).
void forget_peak_memory();

/// Largest resident memory of this process since it began or since forget_peak_memory, in bytes; 0 where the system
/// does not say.
std::uint64_t peak_memory_bytes();

/// Memory of the machine, or what a control group lets this process have of it, in bytes; 0 where the system does not
/// say.
std::uint64_t machine_memory_bytes();

/// Declares `--max-memory MB`.
void add_max_memory(CLI::App& command, std::optional<std::uint64_t>& megabytes);
/// The limit in bytes that it means: by default machine_memory_bytes, and none where that is not known.
std::optional<std::uint64_t> max_memory_bytes(const std::optional<std::uint64_t>& megabytes);

}  // namespace poise::app
