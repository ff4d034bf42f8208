// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "math/functions.h"

// The functions of src/math beside those of the C library. Before anything is timed, the two agree to a few units in
// the last place.
namespace poise::math {
namespace {

struct Pair {
  double x = 0, y = 0;
};

struct Timed {
  const char* name;
  double (*own)(Pair);
  double (*of_library)(Pair);
  double least, most;      // of x
  double least_y, most_y;  // of y
};

double of_both(Pair p) {
  const SinCos both = sin_cos(p.x);
  return both.sin + both.cos;
}

constexpr Timed kTimed[] = {
    {"sin_and_cos", of_both, [](Pair p) { return std::sin(p.x) + std::cos(p.x); }, 0.125, 7, 0, 0},
    {"sin_and_cos_below_an_eighth", of_both, [](Pair p) { return std::sin(p.x) + std::cos(p.x); }, -0.125, 0.125, 0, 0},
    {"exp", [](Pair p) { return math::exp(p.x); }, [](Pair p) { return std::exp(p.x); }, -10, 10, 0, 0},
    {"log", [](Pair p) { return math::log(p.x); }, [](Pair p) { return std::log(p.x); }, 1e-3, 1e3, 0, 0},
    {"pow", [](Pair p) { return math::pow(p.x, p.y); }, [](Pair p) { return std::pow(p.x, p.y); }, 0.1, 8, -8, 8},
    {"atan2", [](Pair p) { return math::atan2(p.y, p.x); }, [](Pair p) { return std::atan2(p.y, p.x); }, -1, 1, -1, 1},
    {"acos", [](Pair p) { return math::acos(p.x); }, [](Pair p) { return std::acos(p.x); }, -1, 1, 0, 0},
    {"cbrt", [](Pair p) { return math::cbrt(p.x); }, [](Pair p) { return std::cbrt(p.x); }, -1e3, 1e3, 0, 0}};

std::vector<Pair> arguments(const Timed& of) {
  std::vector<Pair> made;
  std::uint64_t state = 1;
  // splitmix64 (Steele 2014)
  const auto share = [&state] {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 4096; ++i)
    made.push_back({std::lerp(of.least, of.most, share()), std::lerp(of.least_y, of.most_y, share())});
  return made;
}

void time(benchmark::State& state, const Timed& of, double (*function)(Pair)) {
  const std::vector<Pair> pairs = arguments(of);
  for (const Pair& pair : pairs) {
    const double expected = of.of_library(pair);
    if (std::abs(of.own(pair) - expected) > 4e-16 * (1 + std::abs(expected))) {
      state.SkipWithError("src/math and the C library differ");
      return;
    }
  }
  for (auto _ : state) {
    for (const Pair& pair : pairs) benchmark::DoNotOptimize(function(pair));
  }
  // Seconds a call; the console shows them with their prefix.
  state.counters["call"] = benchmark::Counter(
      static_cast<double>(pairs.size()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

const bool kRegistered = [] {
  for (const Timed& of : kTimed) {
    benchmark::RegisterBenchmark((std::string(of.name) + "/poise").c_str(), time, of, of.own);
    benchmark::RegisterBenchmark((std::string(of.name) + "/library").c_str(), time, of, of.of_library);
  }
  return true;
}();

}  // namespace
}  // namespace poise::math
