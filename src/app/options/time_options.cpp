// SPDX-License-Identifier: MIT
#include "app/options/time_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "app/options/option_values.h"
#include "poise/assets/tree_cache.h"

namespace poise::app {
namespace {

constexpr double kLongestHostMs = 1e6;

bool read_ms(std::string_view text, double& into) {
  const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), into);
  return failure == std::errc{} && stop == text.data() + text.size() && std::isfinite(into) && into >= 0 &&
         into <= kLongestHostMs;
}

void add_render_load(CLI::App& command, TimeOptions& options) {
  const auto read = [&options](const std::string& text) {
    const std::size_t comma = text.find(',');
    std::array<double, 2> load{};
    const bool sound = read_ms(std::string_view(text).substr(0, comma), load[0]) &&
                       (comma == std::string::npos || read_ms(std::string_view(text).substr(comma + 1), load[1])) &&
                       load[1] <= load[0];
    if (!sound) {
      throw CLI::ValidationError(
          fmt::format("--render-load = {}, must be MS or MS,JITTER, each from 0 to {:g} and JITTER at most MS", text,
                      kLongestHostMs),
          CLI::ExitCodes::ValidationError);
    }
    options.render_load_ms = load;
  };
  command
      .add_option_function<std::string>(
          "--render-load", read,
          "Keep the processor busy for so long after each step, before its deadline, as drawing would; JITTER: "
          "each frame's differs by up to this. Reserved as --host-work says, without it as frames before let expect")
      ->type_name("MS[,JITTER]");
}

}  // namespace

void add_time_options(CLI::App& command, TimeOptions& options) {
  add_number(command, "--alpha", options.alpha, 1e-5, false, 0.5,
             "Share of frames whose end may take longer than is kept for it (default: the scene's, else 0.01)")
      ->type_name("SHARE");
  add_render_load(command, options);
  command
      .add_option("--time-priors", options.priors_folder,
                  "Keep what was learned of times between runs in this folder (default: POISE_TIME_PRIORS, else poise "
                  "in the user's cache)")
      ->type_name("DIR");
  command.add_flag("--no-time-priors", options.no_priors,
                   "Learn all times anew and keep nothing; --warmup sets the first frames apart");
}

Status check_time_options(const TimeOptions& options, bool work_clock) {
  if (work_clock && options.alpha) return bad_input("--alpha has no meaning with --clock work");
  if (work_clock && options.render_load_ms) return bad_input("--render-load has no meaning with --clock work");
  if (options.priors_folder && options.no_priors)
    return bad_input("--time-priors has no meaning with --no-time-priors");
  if (options.priors_folder && options.priors_folder->empty()) return bad_input("--time-priors must not be empty");
  return Done{};
}

simulation::RenderLoad render_load_of(const TimeOptions& options, const Scene& scene, std::uint64_t seed) {
  const auto of_ms = [](double ms) { return Nanoseconds(static_cast<std::int64_t>(ms * 1e6)); };
  simulation::RenderLoad load;
  load.seed = seed;
  if (options.render_load_ms) {
    load.mean = of_ms((*options.render_load_ms)[0]);
    load.jitter = of_ms((*options.render_load_ms)[1]);
  } else if (scene.host_work) {
    load.mean = of_ms(scene.host_work->load_ms);
    load.jitter = of_ms(scene.host_work->jitter_ms);
  }
  return load;
}

std::filesystem::path time_priors_folder(const TimeOptions& options) {
  if (options.no_priors) return {};
  if (options.priors_folder) return *options.priors_folder;
  const char* value = std::getenv("POISE_TIME_PRIORS");
  if (value == nullptr) return default_tree_cache_folder();
  const std::string_view text = value;
  return text.empty() || text == "off" ? std::filesystem::path() : std::filesystem::path(text);
}

}  // namespace poise::app
