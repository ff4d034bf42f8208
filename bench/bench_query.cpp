// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "poise/assets/mesh_file.h"
#include "poise/mesh.h"
#include "query/body_index.h"

// Queries of poise/queries.h among many bodies. Before anything is timed, results are compared with those of querying
// every body separately.
namespace poise::query {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

double uniform(std::mt19937_64& random, double least, double most) {
  return least + (most - least) * static_cast<double>(random() >> 11U) * 0x1.0p-53;
}
Vec3 vector_within(std::mt19937_64& random, double most) {
  const double x = uniform(random, -most, most);
  const double y = uniform(random, -most, most);
  return {x, y, uniform(random, -most, most)};
}

ShapePtr jack() {
  Result<TriangleMesh> mesh = read_mesh(std::filesystem::path(POISE_SOURCE_DIR) / "scenes/meshes/jack.obj", {});
  if (!mesh) return nullptr;
  // Queries do not use the tree: one sphere is enough.
  const Sphere all{Vec3::Zero(), 2 * mesh.value().diagonal_m()};
  Result<SphereTree> tree = tree_of_spheres(std::span(&all, 1));
  Result<ShapePtr> shape = make_mesh_shape_with_tree(mesh.value(), tree.value());
  return shape ? shape.value() : nullptr;
}

/// Half balls, half jacks of triangles, about two diameters apart.
struct Bodies {
  std::vector<double> x, y, z, qw, qx, qy, qz;
  std::vector<ShapePtr> shape;
  std::vector<std::uint8_t> alive;
  std::vector<std::uint32_t> generation, group, collides_with;
  double side_m = 1;

  explicit Bodies(std::size_t count) {
    const ShapePtr shapes[2] = {make_sphere_shape(0.5).value(), jack()};
    std::mt19937_64 random(1);
    side_m = 2 * std::cbrt(static_cast<double>(count));
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 p = vector_within(random, 0.5 * side_m);
      const Vec3 v = vector_within(random, 1);
      const Quat q = Quat(uniform(random, -1, 1), v.x(), v.y(), v.z()).normalized();
      x.push_back(p.x());
      y.push_back(p.y());
      z.push_back(p.z());
      qw.push_back(q.w());
      qx.push_back(q.x());
      qy.push_back(q.y());
      qz.push_back(q.z());
      shape.push_back(shapes[i % 2]);
      alive.push_back(shape.back() ? 1 : 0);
      generation.push_back(0);
      group.push_back(1);
      collides_with.push_back(1);
    }
  }
  [[nodiscard]] BodyViews views() const {
    return {x, y, z, qw, qx, qy, qz, shape, alive, generation, group, collides_with};
  }
};

struct Asked {
  Vec3 point, direction;
};
std::vector<Asked> questions(double side_m) {
  std::mt19937_64 random(2);
  std::vector<Asked> asked(256);
  for (Asked& a : asked) {
    a.point = vector_within(random, 0.5 * side_m);
    a.direction = vector_within(random, 1).normalized();
  }
  return asked;
}

/// Empty if the index gives the same results as the bodies queried one by one.
std::string check(const Bodies& bodies, const BodyIndex& index) {
  const BodyViews views = bodies.views();
  for (std::size_t i = 0; i < views.slot_count(); ++i) {
    if (views.alive[i] == 0) return "scenes/meshes/jack.obj could not be read";
  }
  const BodySurface surfaces[2] = {BodySurface(bodies.shape[0]), BodySurface(bodies.shape[1])};
  std::size_t hits = 0;
  for (const Asked& a : questions(bodies.side_m)) {
    double ray = kFar;
    double near = kFar;
    for (std::size_t i = 0; i < views.slot_count(); ++i) {
      const Mat3 into = views.rotation(i).transpose();
      const Vec3 point = into * (a.point - views.position(i));
      const auto hit = surfaces[i % 2].cast_ray(point, (into * a.direction).normalized(), ray, false);
      if (hit) ray = std::min(ray, hit->distance_m);
      const auto closest = surfaces[i % 2].closest(point, near);
      if (closest) near = std::min(near, std::abs(closest->distance_m));
    }
    const auto hit = index.cast_ray(views, {a.point, a.direction}, {});
    const auto closest = index.closest_point(views, a.point, kFar, {});
    if (hit.has_value() != (ray < kFar)) return "a ray is hit or missed wrongly";
    if (hit && !(std::abs(hit->distance_m - ray) < 1e-9)) return "a ray hits at the wrong distance";
    if (!closest || !(std::abs(std::abs(closest->distance_m) - near) < 1e-9)) return "a closest point is wrong";
    hits += hit ? 1U : 0U;
  }
  return hits > 16 ? "" : "rays hit too little to tell";
}

template <class Question>
void time_queries(benchmark::State& state, Question&& question) {
  const Bodies bodies(static_cast<std::size_t>(state.range(0)));
  BodyIndex index;
  index.update(bodies.views());
  if (const std::string wrong = check(bodies, index); !wrong.empty()) {
    state.SkipWithError(wrong.c_str());
    return;
  }
  const std::vector<Asked> asked = questions(bodies.side_m);
  std::size_t next = 0;
  for (auto _ : state) question(bodies.views(), index, asked[next++ % asked.size()]);
}

void rays(benchmark::State& state) {
  time_queries(state, [](const BodyViews& bodies, const BodyIndex& index, const Asked& a) {
    benchmark::DoNotOptimize(index.cast_ray(bodies, {a.point, a.direction}, {}));
  });
}
void spheres(benchmark::State& state) {
  time_queries(state, [](const BodyViews& bodies, const BodyIndex& index, const Asked& a) {
    benchmark::DoNotOptimize(index.cast_sphere(bodies, {a.point, 0.1, a.direction}, {}));
  });
}
void closest_points(benchmark::State& state) {
  time_queries(state, [](const BodyViews& bodies, const BodyIndex& index, const Asked& a) {
    benchmark::DoNotOptimize(index.closest_point(bodies, a.point, kFar, {}));
  });
}
void overlaps(benchmark::State& state) {
  std::vector<BodyId> found;
  time_queries(state, [&](const BodyViews& bodies, const BodyIndex& index, const Asked& a) {
    index.overlap_sphere(bodies, a.point, 1, {}, found);
    benchmark::DoNotOptimize(found.data());
  });
}
/// Cost of the index update in the first query after a step.
void updates(benchmark::State& state) {
  Bodies bodies(static_cast<std::size_t>(state.range(0)));
  BodyIndex index;
  index.update(bodies.views());
  if (const std::string wrong = check(bodies, index); !wrong.empty()) {
    state.SkipWithError(wrong.c_str());
    return;
  }
  for (auto _ : state) index.update(bodies.views());
}

BENCHMARK(rays)->Arg(100)->Arg(1000)->Arg(10000);
BENCHMARK(spheres)->Arg(100)->Arg(1000)->Arg(10000);
BENCHMARK(closest_points)->Arg(100)->Arg(1000)->Arg(10000);
BENCHMARK(overlaps)->Arg(100)->Arg(1000)->Arg(10000);
BENCHMARK(updates)->Arg(1000)->Arg(10000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace poise::query
