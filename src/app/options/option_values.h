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

/// Adds `--name` and `--no-name`; at most one may be given. `target` stays empty without either.
void add_switch(CLI::App& app, const std::string& name, std::optional<bool>& target, const std::string& help);

/// For each of several values: a finite number in [min, max].
CLI::Validator numbers_within(double min, double max);

/// Adds `name` for `every=K` with a whole K in [1, max]; anything else is a usage error that tells the form.
CLI::Option* add_every(CLI::App& app, const std::string& name, std::optional<std::uint64_t>& target, std::uint64_t max,
                       const std::string& help);

/// Adds `name` for a text. An empty one is a usage error: it comes from a variable that was not set.
CLI::Option* add_text(CLI::App& app, const std::string& name, std::string& target, const std::string& help);

/// Adds `name` for a file or folder. An empty name is one too.
CLI::Option* add_path(CLI::App& app, const std::string& name, std::string& target, const std::string& help);

/// The argument SCENE, which must be there: see read_scene_argument.
CLI::Option* add_scene(CLI::App& app, std::string& target);

}  // namespace poise::app
