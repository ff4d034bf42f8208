// SPDX-License-Identifier: MIT
// Refining one pair of jacks from the root spheres to the leaves, near the first touch: nanoseconds a pair and an
// expansion.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>
#include <vector>

#include "collision/front/pair_refinement.h"

namespace poise::collision {
namespace {

double uniform(std::mt19937_64& random) { return 2.0 * static_cast<double>(random() >> 11U) * 0x1.0p-53 - 1.0; }

ShapePtr make_jack() {
  std::vector<Sphere> spheres = {{Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      spheres.push_back({side * 0.35 * Vec3::Unit(axis), 0.22});
      spheres.push_back({side * 0.68 * Vec3::Unit(axis), 0.18});
    }
  }
  return make_spheres_shape(spheres).value();
}

double least_gap_m(const PairFrame& frame) {
  double least = 1e300;
  for (const NodeIndex a : frame.a->tree.nodes_at(frame.a->tree.depth())) {
    for (const NodeIndex b : frame.b->tree.nodes_at(frame.b->tree.depth())) {
      least = std::min(least, sphere_contact(frame, {a, b}).gap_m);
    }
  }
  return least;
}

struct Posed {
  Pose a, b;
};

// Random poses whose surfaces are within a centimetre of contact.
std::vector<Posed> near_touches(const Shape& jack, std::size_t count) {
  std::mt19937_64 random(3);
  std::vector<Posed> poses;
  while (poses.size() < count) {
    Posed posed;
    posed.a.rotation =
        Quat(uniform(random), uniform(random), uniform(random), uniform(random)).normalized().toRotationMatrix();
    posed.b.rotation =
        Quat(uniform(random), uniform(random), uniform(random), uniform(random)).normalized().toRotationMatrix();
    posed.b.position_m = 1.4 * Vec3(uniform(random), uniform(random), uniform(random));
    if (std::abs(least_gap_m(make_pair_frame(jack, posed.a, jack, posed.b, 0, 0))) < 0.01) poses.push_back(posed);
  }
  return poses;
}

std::uint32_t refine(const PairFrame& frame, std::span<FrontPool> pools, SinglePair& pair) {
  std::uint32_t expansions = 0;
  pair.deepest = deepest_level(*frame.a, *frame.b, kMaxTreeDepth);
  while (pair.refinable()) {
    expansions += pair.front_entries;
    LevelProgress progress = begin_level(pair, pools[0]);
    while (run_quantum(frame, pools, 0, 512, progress) == Quantum::More) {
    }
    publish_level(frame, Mat3::Identity(), progress, pair, pair);
    if (pair.points_due && !pair.refinable()) make_points(frame, pools, pair, pair);
  }
  return expansions;
}

void root_to_leaves(benchmark::State& state) {
  const ShapePtr jack = make_jack();
  const auto poses = near_touches(*jack, 1000);
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 16U);
  for (const Posed& posed : poses) {
    const PairFrame frame = make_pair_frame(*jack, posed.a, *jack, posed.b, 0.02, 0.001);
    SinglePair pair;
    pools[0].clear();
    refine(frame, pools, pair);
    if (pair.apart || pair.contact.spheres_m != least_gap_m(frame)) state.SkipWithError("a wrong answer");
  }
  std::size_t next = 0;
  std::size_t expansions = 0;
  for (auto _ : state) {
    const Posed& posed = poses[next];
    next = next + 1 == poses.size() ? 0 : next + 1;
    const PairFrame frame = make_pair_frame(*jack, posed.a, *jack, posed.b, 0.02, 0.001);
    SinglePair pair;
    pools[0].clear();
    expansions += refine(frame, pools, pair);
    benchmark::DoNotOptimize(pair.contact.estimated_separation_m);
  }
  state.counters["expansions_per_pair"] = static_cast<double>(expansions) / static_cast<double>(state.iterations());
  state.counters["s_per_expansion"] =
      benchmark::Counter(static_cast<double>(expansions), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(root_to_leaves);

}  // namespace
}  // namespace poise::collision
