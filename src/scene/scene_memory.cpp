// SPDX-License-Identifier: MIT
#include "scene/scene_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "parallel/executor.h"
#include "scene/generators.h"

namespace poise::io {
namespace {

constexpr double kMebibyte = 1024.0 * 1024.0;

/// Of `count` bodies of a generator, the number that are there at once, at most. Each is there for a frame at least.
double at_once(const SceneGenerator& generator, std::uint64_t count, double dt_s) {
  const auto all = static_cast<double>(count);
  const auto* stream = std::get_if<StreamGenerator>(&generator);
  if (stream == nullptr || !stream->life_s || !(stream->to_s > stream->from_s)) return all;
  // In a frame those come that were due since the one before, and those leave that have lived for life_s.
  const double there_s = *stream->life_s + 2 * dt_s;
  return std::min(all, std::ceil(all * there_s / (stream->to_s - stream->from_s)) + 1);
}

}  // namespace

BodyNumbers body_numbers(const Scene& scene, std::optional<std::uint64_t> bodies) {
  BodyNumbers numbers;
  numbers.at_once = static_cast<double>(scene.bodies.size()) + (scene.tray ? 5 : 0);
  const std::vector<std::uint64_t> counts = generated_counts(scene, bodies);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    numbers.at_once += at_once(scene.generators[i], counts[i], scene.dt_s);
    numbers.generated += static_cast<double>(counts[i]);
  }
  return numbers;
}

double bodies_bytes(const BodyNumbers& numbers, int threads) {
  const int used = threads > 0 ? threads : parallel::available_threads();
  return kBaseBytes + kBytesOfThread * used + kBytesOfBody * numbers.at_once + kBytesOfGenerated * numbers.generated;
}

Result<std::uint32_t> pairs_that_fit(const Scene& scene, std::optional<std::uint64_t> bodies, int threads,
                                     std::uint64_t limit_bytes, std::uint32_t most) {
  constexpr double kFewestPairs = 1024;
  const BodyNumbers numbers = body_numbers(scene, bodies);
  const double needed_bytes = bodies_bytes(numbers, threads);
  const double least_bytes = needed_bytes + kFewestPairs * kBytesOfPair;
  const auto limit = static_cast<double>(limit_bytes);
  if (limit < least_bytes) {
    return bad_input(
        fmt::format("{}: {:.0f} bodies at once, of {:.0f} that are generated, take about {:.0f} MiB, must be at most "
                    "the {:.0f} MiB "
                    "that a run may take (--max-memory)",
                    scene.source, numbers.at_once, numbers.generated, std::ceil(least_bytes / kMebibyte),
                    std::floor(limit / kMebibyte)));
  }
  return static_cast<std::uint32_t>(std::min(static_cast<double>(most), (limit - needed_bytes) / kBytesOfPair));
}

}  // namespace poise::io
