// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include <random>

#include "geometry/procedural.h"
#include "geometry/triangle_bvh.h"
#include "poise/mesh.h"
#include "poise/sphere_tree.h"

namespace {

using poise::SphereTree;
using poise::TriangleMesh;
using poise::Vec3;

/// Empty when the tree covers all samples at every level.
const char* wrong_tree(const SphereTree& tree, const TriangleMesh& mesh) {
  const auto levels = poise::judge_tree(tree, mesh, {.samples = 5000, .seed = 7});
  if (!levels) return "the tree cannot be judged";
  for (const poise::TreeLevelFigures& f : levels.value()) {
    if (f.surface_coverage < 1 || f.inside_coverage < 1) return "the tree does not cover its mesh";
  }
  return "";
}

void build_tree(benchmark::State& state, const char* kind) {
  const TriangleMesh mesh = poise::geometry::make_procedural_shape(kind).value();
  const poise::TreeBuildOptions options{
      .depth = static_cast<poise::Level>(state.range(0)), .seed = 1, .threads = static_cast<int>(state.range(1))};
  const auto checked = poise::build_sphere_tree(mesh, options);
  const char* wrong = checked ? wrong_tree(checked.value(), mesh) : checked.error().message.c_str();
  if (*wrong != '\0') {
    state.SkipWithError(wrong);
    return;
  }
  for (auto _ : state) {
    const auto tree = poise::build_sphere_tree(mesh, options);
    benchmark::DoNotOptimize(tree.value().radius_m.data());
  }
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
  state.counters["nodes"] = static_cast<double>(checked.value().node_count());
}

void jack(benchmark::State& state) { build_tree(state, "jack"); }
void slab(benchmark::State& state) { build_tree(state, "slab"); }

BENCHMARK(jack)->ArgNames({"depth", "threads"})->ArgsProduct({{1, 2, 3}, {1, 2}})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(slab)->ArgNames({"depth", "threads"})->ArgsProduct({{1, 2, 3}, {1}})->Unit(benchmark::kMillisecond)->UseRealTime();

/// Signed distance, which the search for deep balls asks for most.
void signed_distance(benchmark::State& state) {
  const poise::geometry::TriangleBvh bvh(poise::geometry::make_procedural_shape("torus").value());
  // On the circle of the tube's centres it is the tube's radius, but for the facets.
  if (std::abs(bvh.signed_distance_m({0.35, 0, 0}) + 0.15) > 0.01) {
    state.SkipWithError("the distance is wrong");
    return;
  }
  std::mt19937_64 random(1);
  std::vector<Vec3> points;
  for (int i = 0; i < 1024; ++i) {
    const auto coordinate = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
    const double x = coordinate();
    const double y = coordinate();
    points.emplace_back(x, y, coordinate());
  }
  std::size_t next = 0;
  for (auto _ : state) benchmark::DoNotOptimize(bvh.signed_distance_m(points[next++ % points.size()]));
}
BENCHMARK(signed_distance);

}  // namespace
