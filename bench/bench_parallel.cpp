// SPDX-License-Identifier: MIT
// The cost of bringing workers to a loop: back to back, and after the pause of a frame, when they sleep.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "latencies.h"
#include "parallel/executor.h"

namespace poise::parallel {
namespace {

constexpr std::size_t kItems = 400;

/// About a microsecond of arithmetic that no compiler removes.
std::uint64_t item(std::size_t index) {
  std::uint64_t x = index + 1;
  for (int i = 0; i < 400; ++i) x = x * 6364136223846793005U + 1442695040888963407U;
  return x;
}

std::vector<std::uint64_t> expected_results() {
  std::vector<std::uint64_t> results(kItems);
  for (std::size_t i = 0; i < kItems; ++i) results[i] = item(i);
  return results;
}

void fill(Executor& executor, std::vector<std::uint64_t>& results) {
  parallel_for(executor, results.size(), 4, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) results[i] = item(i);
  });
}

std::unique_ptr<Executor> executor_of(const benchmark::State& state) {
  return make_executor(static_cast<ExecutorKind>(state.range(0)), static_cast<int>(state.range(1)));
}

void name(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"kind", "threads"})->UseManualTime()->Unit(benchmark::kMicrosecond);
  for (const ExecutorKind kind : {ExecutorKind::Tbb, ExecutorKind::Threads}) {
    for (const int threads : {1, 2, 8}) benchmark->Args({static_cast<std::int64_t>(kind), threads});
  }
}

void empty_run(benchmark::State& state) {
  const auto executor = executor_of(state);
  bench::Latencies latencies;
  for (auto _ : state) {
    latencies.time(state, [&] { executor->run([](int worker) { benchmark::DoNotOptimize(worker); }); });
  }
  latencies.report(state);
}
BENCHMARK(empty_run)->Apply(name);

void loop_of_400_items(benchmark::State& state) {
  const auto executor = executor_of(state);
  const std::vector<std::uint64_t> expected = expected_results();
  std::vector<std::uint64_t> results(kItems);
  fill(*executor, results);
  if (results != expected) state.SkipWithError("a wrong answer");
  bench::Latencies latencies;
  for (auto _ : state) latencies.time(state, [&] { fill(*executor, results); });
  if (results != expected) state.SkipWithError("a wrong answer");
  latencies.report(state);
}
BENCHMARK(loop_of_400_items)->Apply(name);

/// Like a frame: a pause until the release, a serial part (with or without a wake before it), then the loop.
void loop_after_a_pause(benchmark::State& state, bool wake) {
  const auto executor = executor_of(state);
  const std::vector<std::uint64_t> expected = expected_results();
  std::vector<std::uint64_t> results(kItems);
  bench::Latencies latencies;
  for (auto _ : state) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (wake) executor->wake();
    std::uint64_t serial = 0;
    for (std::size_t i = 0; i < 40; ++i) serial += item(i);
    benchmark::DoNotOptimize(serial);
    latencies.time(state, [&] { fill(*executor, results); });
  }
  if (results != expected) state.SkipWithError("a wrong answer");
  latencies.report(state);
}
BENCHMARK_CAPTURE(loop_after_a_pause, asleep, false)->Apply(name);
BENCHMARK_CAPTURE(loop_after_a_pause, woken, true)->Apply(name);

}  // namespace
}  // namespace poise::parallel
