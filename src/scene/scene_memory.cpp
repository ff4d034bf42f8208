// SPDX-License-Identifier: MIT
#include "scene/scene_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/generators.h"

namespace poise::io {
namespace {

constexpr double kMebibyte = 1024.0 * 1024.0;

/// Of `count` bodies of a generator, the number that are there at once, at most.
double at_once(const SceneGenerator& generator, std::uint64_t count) {
  const auto all = static_cast<double>(count);
  const auto* stream = std::get_if<StreamGenerator>(&generator);
  if (stream == nullptr || !stream->life_s || !(stream->to_s > stream->from_s)) return all;
  return std::min(all, std::ceil(all * *stream->life_s / (stream->to_s - stream->from_s)) + 1);
}

}  // namespace

Result<std::uint32_t> pairs_that_fit(const Scene& scene, std::optional<std::uint64_t> bodies, int threads,
                                     std::uint64_t limit_bytes, std::uint32_t most) {
  const std::vector<std::uint64_t> counts = generated_counts(scene, bodies);
  double there = static_cast<double>(scene.bodies.size()) + (scene.tray ? 5 : 0);
  double generated = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    there += at_once(scene.generators[i], counts[i]);
    generated += static_cast<double>(counts[i]);
  }
  const double needed_bytes =
      kBaseBytes + kBytesOfThread * threads + kBytesOfBody * there + kBytesOfGenerated * generated;
  const double left_bytes = static_cast<double>(limit_bytes) - needed_bytes;
  constexpr double kFewestPairs = 1024;
  if (left_bytes < kFewestPairs * kBytesOfPair) {
    return bad_input(
        fmt::format("{}: {:.0f} bodies at once take about {:.0f} MiB, must be at most the {:.0f} MiB that a "
                    "run may take (--max-memory)",
                    scene.source, there, std::ceil(needed_bytes / kMebibyte),
                    std::floor(static_cast<double>(limit_bytes) / kMebibyte)));
  }
  return static_cast<std::uint32_t>(std::min(static_cast<double>(most), left_bytes / kBytesOfPair));
}

}  // namespace poise::io
