// SPDX-License-Identifier: MIT
// The broad phase on loose piles of equal balls and of balls of many sizes: microseconds for all pairs. And on a crowd.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "latencies.h"

namespace poise::collision {
namespace {

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11U) * 0x1.0p-53; }

// Balls at the density of a pile of five layers; the smallest and the largest differ by 2^octaves.
std::vector<MotionBound> pile(std::size_t count, double octaves) {
  std::mt19937_64 random(1);
  const double side_m = std::sqrt(static_cast<double>(count) / 5.0);
  std::vector<MotionBound> bounds(count);
  for (std::size_t i = 0; i < count; ++i) {
    bounds[i].center_m = {side_m * uniform(random), side_m * uniform(random), 5.0 * uniform(random)};
    bounds[i].radius_m = 0.6 * std::exp2(-octaves * uniform(random));
    bounds[i].slot = static_cast<std::uint32_t>(i);
  }
  return bounds;
}

bool matches_brute_force(std::span<const MotionBound> bounds, std::span<const CandidatePair> pairs) {
  std::size_t next = 0;
  for (std::uint32_t i = 0; i < bounds.size(); ++i) {
    for (std::uint32_t j = i + 1; j < bounds.size(); ++j) {
      const double reach = bounds[i].radius_m + bounds[j].radius_m;
      if ((bounds[i].center_m - bounds[j].center_m).squaredNorm() >= reach * reach) continue;
      if (next == pairs.size() || !(pairs[next++] == CandidatePair{i, j})) return false;
    }
  }
  return next == pairs.size();
}

void find_pairs(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  const auto executor = parallel::make_executor(ExecutorKind::Tbb, static_cast<int>(state.range(2)));
  const auto octaves = static_cast<double>(state.range(1));
  BroadPhase broad;
  const auto small = pile(2000, octaves);
  if (!matches_brute_force(small, broad.find(small, {}, {65536}, *executor).pairs))
    state.SkipWithError("a wrong answer");
  const auto bounds = pile(count, octaves);
  std::size_t pairs = 0;
  bench::Latencies latencies;
  for (auto _ : state) {
    latencies.time(state, [&] { pairs = broad.find(bounds, {}, {65536}, *executor).pairs.size(); });
  }
  latencies.report(state);
  state.counters["pairs_per_body"] = static_cast<double>(pairs) / static_cast<double>(count);
}
BENCHMARK(find_pairs)
    ->ArgNames({"bodies", "octaves", "threads"})
    ->ArgsProduct({{2000, 20000}, {0, 4}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

// All in one place, so that each overlaps all others: the time for one body must not grow with their number.
void find_pairs_of_a_crowd(benchmark::State& state) {
  constexpr std::uint32_t kMostPartners = 16;
  const auto count = static_cast<std::size_t>(state.range(0));
  const auto executor = parallel::make_executor(ExecutorKind::Tbb, 1);
  auto bounds = pile(count, 0);
  for (MotionBound& bound : bounds) bound.center_m = Vec3::Zero();
  BroadPhase broad;
  std::size_t pairs = 0;
  for (auto _ : state) pairs = broad.find(bounds, {}, {kMostPartners}, *executor).pairs.size();
  state.counters["pairs_per_body"] = static_cast<double>(pairs) / static_cast<double>(count);
  state.counters["time_per_body"] = benchmark::Counter(
      static_cast<double>(count), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(find_pairs_of_a_crowd)->ArgName("bodies")->Arg(2000)->Arg(20000)->Arg(100000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace poise::collision
