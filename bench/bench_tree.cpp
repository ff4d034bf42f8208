// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include <random>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/mesh/procedural.h"
#include "geometry/sphere_tree/node_fit.h"
#include "geometry/sphere_tree/tree_protrusion.h"
#include "poise/mesh.h"
#include "poise/sphere_tree.h"

namespace {

using poise::SphereTree;
using poise::TriangleMesh;
using poise::Vec3;

/// Empty if the tree covers all samples at every level.
const char* wrong_tree(const SphereTree& tree, const TriangleMesh& mesh) {
  const auto levels = poise::measure_tree_quality(tree, mesh, {.samples = 5000, .seed = 7});
  if (!levels) return "the tree cannot be measured";
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

BENCHMARK(jack)
    ->ArgNames({"depth", "threads"})
    ->ArgsProduct({{1, 2, 3}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(slab)
    ->ArgNames({"depth", "threads"})
    ->ArgsProduct({{1, 2, 3}, {1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

std::vector<Vec3> points_around(double half_m) {
  std::mt19937_64 random(1);
  const auto coordinate = [&] { return half_m * (static_cast<double>(random() >> 11U) * 0x1.0p-52 - 1); };
  std::vector<Vec3> points;
  for (int i = 0; i < 4096; ++i) {
    const double x = coordinate();
    const double y = coordinate();
    points.emplace_back(x, y, coordinate());
  }
  return points;
}

/// One query on a torus of 1,024 triangles, of the kind that the builder and the bounds use most.
template <class Ask>
void ask_torus(benchmark::State& state, Ask&& ask) {
  const poise::geometry::TriangleBvh bvh(poise::geometry::make_procedural_shape("torus").value());
  // On the circle of the tube's centres the distance is the tube's radius, up to the facets.
  if (std::abs(bvh.signed_distance_m({0.35, 0, 0}) + 0.15) > 0.01) {
    state.SkipWithError("the distance is wrong");
    return;
  }
  const std::vector<Vec3> points = points_around(0.5);
  std::size_t next = 0;
  for (auto _ : state) benchmark::DoNotOptimize(ask(bvh, points[next++ % points.size()]));
}
void closest(benchmark::State& state) {
  ask_torus(state, [](const auto& bvh, const Vec3& point) { return bvh.closest(point).squared_distance_m2; });
}
void inside(benchmark::State& state) {
  ask_torus(state, [](const auto& bvh, const Vec3& point) { return bvh.inside(point); });
}
void signed_distance(benchmark::State& state) {
  ask_torus(state, [](const auto& bvh, const Vec3& point) { return bvh.signed_distance_m(point); });
}
BENCHMARK(closest);
BENCHMARK(inside);
BENCHMARK(signed_distance);

/// Bounds and surfaces of all nodes of a tree of depth 2, on one thread.
void measure_nodes(benchmark::State& state) {
  const TriangleMesh mesh = poise::geometry::make_procedural_shape("torus").value();
  SphereTree tree = poise::build_sphere_tree(mesh, {.depth = 2}).value();
  const auto figures = poise::measure_tree_quality(tree, mesh, {.samples = 20000, .seed = 7}).value();
  for (const poise::TreeLevelFigures& f : figures) {
    if (f.protrusion_max_m <= f.protrusion_bound_max_m) continue;
    state.SkipWithError("a sample stands out farther than the bound");
    return;
  }
  const poise::geometry::TriangleBvh bvh(mesh);
  const auto serial = poise::parallel::make_executor(poise::ExecutorKind::Serial, 1);
  for (auto _ : state) {
    poise::geometry::measure_protrusions(tree, bvh, *serial);
    poise::geometry::fit_nodes(tree, mesh, bvh, *serial);
    benchmark::DoNotOptimize(tree.fit.data());
  }
  state.counters["nodes"] = static_cast<double>(tree.node_count());
}
BENCHMARK(measure_nodes)->Unit(benchmark::kMillisecond);

}  // namespace
