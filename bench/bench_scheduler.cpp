// SPDX-License-Identifier: MIT
// The cost of scheduling decisions: a score and its band, rounds of the work clock, the bands that workers share, and a
// check of the budget.
#include <benchmark/benchmark.h>

#include <array>
#include <vector>

#include "poise/scheduler/frame_budget.h"
#include "poise/scheduler/policy.h"
#include "poise/scheduler/priority_bands.h"
#include "poise/scheduler/refine_until.h"
#include "poise/scheduler/rounds.h"

namespace poise::scheduler {
namespace {

constexpr std::array<float, 5> kErrors = {0.4F, 0.2F, 0.1F, 0.04F, 0.01F};

PairCues cues_of(std::size_t i) {
  PairCues cues;
  cues.angle_radpm = 0.01 + 1e-4 * static_cast<double>(i % 97);
  cues.eccentricity_rad = 1e-3 * static_cast<double>(i % 1009);
  cues.closing_mps = 0.1 * static_cast<double>(i % 13);
  cues.frames_waited = static_cast<std::uint32_t>(i % 7);
  return cues;
}

double errors_by_host(const FrameFacts& /*frame*/, const PairChain& chain, const PairCues& cues,
                      void* /*context*/) noexcept {
  return static_cast<double>(chain.error_m[chain.level]) * cues.angle_radpm * (1.0 + cues.closing_mps);
}

void score_and_band(benchmark::State& state) {
  Policy policy{static_cast<PolicyKind>(state.range(0))};
  policy.custom = {errors_by_host, nullptr};
  const FrameFacts frame{7, 1, 4, 1000};
  std::vector<PairCues> cues;
  for (std::size_t i = 0; i < 1000; ++i) cues.push_back(cues_of(i));
  const auto scored = [&](std::size_t i) {
    return score(policy, frame, {i, 1, kErrors, 1 + i % 20}, cues[i], static_cast<std::uint32_t>(i));
  };
  for (std::size_t i = 1; i < 1000; ++i) {
    if ((scored(i) > scored(i - 1)) && band_of(policy, scored(i)) < band_of(policy, scored(i - 1))) {
      state.SkipWithError("bands out of order");
    }
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(band_of(policy, scored(i)));
    i = i + 1 == cues.size() ? 0 : i + 1;
  }
}
BENCHMARK(score_and_band)->ArgName("policy")->DenseRange(0, 3);

void rounds(benchmark::State& state) {
  const auto count = static_cast<std::uint32_t>(state.range(0));
  RoundSelector selector;
  std::uint64_t served = 0;
  for (auto _ : state) {
    selector.begin_frame(~std::uint64_t{0}, count);
    for (std::uint32_t i = 0; i < count; ++i) selector.add({1.0 / (1 + (i * 7919U) % count), i, 1});
    served = 0;
    for (auto round = selector.next_round(); !round.empty(); round = selector.next_round()) served += round.size();
  }
  if (served != count) state.SkipWithError("candidates were lost");
  state.counters["s_per_candidate"] = benchmark::Counter(
      static_cast<double>(count), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(rounds)->ArgName("candidates")->Arg(20000)->Unit(benchmark::kMicrosecond);

void bands(benchmark::State& state) {
  constexpr std::uint32_t kItems = 20000;
  PriorityBands shared;
  for (auto _ : state) {
    shared.reset(kItems);
    for (std::uint32_t i = 0; i < kItems; ++i) shared.put(i, (i * 7919U) % kBands);
    std::uint32_t taken = 0;
    while (shared.take() != PriorityBands::kNone) ++taken;
    if (taken != kItems) state.SkipWithError("items were lost");
  }
  state.counters["s_per_item"] =
      benchmark::Counter(double{kItems}, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(bands)->Unit(benchmark::kMicrosecond);

double near_first(const PairView& view, void* /*context*/) noexcept { return 1.0 / (1.0 + view.distance_m); }

void host_cue(benchmark::State& state) {
  const HostCue cue{near_first, nullptr};
  PairView view;
  view.distance_m = 3;
  if (host_factor(cue, view).factor != 0.25F) state.SkipWithError("a wrong answer");
  for (auto _ : state) {
    benchmark::DoNotOptimize(view);
    benchmark::DoNotOptimize(host_factor(cue, view));
  }
}
BENCHMARK(host_cue);

// The loop alone: jobs that do nothing, with a counter as the clock.
void refine_until_a_job(benchmark::State& state) {
  constexpr std::uint32_t kItems = 20000;
  RefineQueue queue;
  const FrameBudget budget = make_frame_budget(TimePoint(std::chrono::hours(1)), Nanoseconds(0), TailForecast{},
                                               TrackedQuantile{}, {2000, 0, 9000, 0}, 40);
  for (auto _ : state) {
    queue.begin_frame(kItems, kItems);
    for (std::uint32_t i = 0; i < kItems; ++i) queue.add(i, (i * 7919U) % kBands, 8);
    TimePoint clock{};
    const RefineCounts counts = refine_until(
        queue, budget, 512, [&] { return clock += Nanoseconds(1); },
        [](std::uint32_t, std::uint64_t units) {
          return JobOutcome{JobOutcome::Kind::Done, units, 0, 0, -1};
        });
    if (counts.jobs != kItems || queue.open() != 0) state.SkipWithError("items were lost");
  }
  state.counters["s_per_job"] =
      benchmark::Counter(double{kItems}, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(refine_until_a_job)->Unit(benchmark::kMicrosecond);

void admission(benchmark::State& state) {
  const FrameBudget budget = make_frame_budget(TimePoint(std::chrono::hours(1)), Nanoseconds(0), TailForecast{},
                                               TrackedQuantile{}, {2000, 0, 9000, 0}, 40);
  if (!budget.admits(TimePoint{}, 100, 9000) || budget.admits(TimePoint(std::chrono::hours(1)), 1, 0)) {
    state.SkipWithError("a wrong answer");
  }
  std::uint64_t contacts = 0;
  for (auto _ : state) benchmark::DoNotOptimize(budget.admits(TimePoint{}, 12, ++contacts & 1023U));
}
BENCHMARK(admission);

}  // namespace
}  // namespace poise::scheduler
