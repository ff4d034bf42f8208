// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

namespace poise::app {

/// Adds `name` for a whole number in [min, max]; anything else is a usage error that tells the range.
CLI::Option* add_whole(CLI::App& app, const std::string& name, std::optional<std::uint64_t>& target, std::uint64_t min,
                       std::uint64_t max, const std::string& help);

/// Adds `name` for a finite number in [min, max], or (min, max] with `open_min`.
CLI::Option* add_number(CLI::App& app, const std::string& name, std::optional<double>& target, double min,
                        bool open_min, double max, const std::string& help);

}  // namespace poise::app
