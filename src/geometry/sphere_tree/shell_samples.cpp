// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/shell_samples.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/mesh/mesh_volume.h"
#include "geometry/primitives/random.h"
#include "math/functions.h"

namespace poise::geometry {
namespace {

struct Sample {
  Vec3f at;
  float distance;
};

/// Traverses an octree of cubes and skips those that are inside, or farther from the surface than the shell is thick.
class Walk {
  // Invariant: every visited cube meets the box of the shell.
 public:
  Walk(const TriangleBvh& bvh, const CoverFrame& frame, float thickness, std::uint64_t seed)
      : bvh_(bvh), frame_(frame), thickness_(thickness), seed_(seed) {}

  /// Visits a cube at `place`, counted in cubes of its size from the low corner; `level` halvings are left.
  void enter(const Vec3f& low, float size, int level, std::uint64_t place, std::vector<Sample>& out) const {
    if (level == 0) return leaf(low, size, place, out);
    const Vec3 middle_m = frame_.from(low + Vec3f::Constant(0.5F * size));
    const double half_m = 0.8661 * static_cast<double>(size) * frame_.diagonal_m;
    const double near_m = half_m + static_cast<double>(thickness_) * frame_.diagonal_m;
    const double square_m2 = bvh_.closest(middle_m, near_m * near_m).squared_distance_m2;
    if (square_m2 >= near_m * near_m || (square_m2 > half_m * half_m && bvh_.inside(middle_m))) return;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const float half = 0.5F * size;
      const Vec3f offset(corner & 1U ? half : 0.0F, corner & 2U ? half : 0.0F, corner & 4U ? half : 0.0F);
      enter(low + offset, half, level - 1, 8 * place + corner, out);
    }
  }

 private:
  void leaf(const Vec3f& low, float size, std::uint64_t place, std::vector<Sample>& out) const {
    Random random = Random::of(seed_, place);
    // In separate statements: the order of evaluation of arguments differs between compilers.
    const double x = random.unit();
    const double y = random.unit();
    const double z = random.unit();
    const Vec3 share(x, y, z);
    const Vec3f at = low + size * share.cast<float>();
    const Vec3 at_m = frame_.from(at);
    const double near_m = static_cast<double>(thickness_) * frame_.diagonal_m;
    const double square_m2 = bvh_.closest(at_m, near_m * near_m).squared_distance_m2;
    if (square_m2 >= near_m * near_m || bvh_.inside(at_m)) return;
    out.push_back({at, static_cast<float>(std::sqrt(square_m2) / frame_.diagonal_m)});
  }

  const TriangleBvh& bvh_;
  const CoverFrame& frame_;
  float thickness_;
  std::uint64_t seed_;
};

void sort_into_cells(const std::vector<Sample>& found, const Vec3f& high, ShellSamples& samples) {
  std::size_t count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    samples.cells[a] = static_cast<int>((high[axis] - samples.low[axis]) / samples.cell) + 1;
    count *= static_cast<std::size_t>(samples.cells[a]);
  }
  const auto cell_of = [&](const Vec3f& at) {
    std::size_t cell = 0;
    for (int axis = 2; axis >= 0; --axis) {
      const int cells = samples.cells[static_cast<std::size_t>(axis)];
      const int i =
          std::clamp(static_cast<int>(std::floor((at[axis] - samples.low[axis]) / samples.cell)), 0, cells - 1);
      cell = cell * static_cast<std::size_t>(cells) + static_cast<std::size_t>(i);
    }
    return cell;
  };
  samples.cell_begin.assign(count + 1, 0);
  for (const Sample& sample : found) ++samples.cell_begin[cell_of(sample.at) + 1];
  for (std::size_t i = 0; i < count; ++i) samples.cell_begin[i + 1] += samples.cell_begin[i];
  std::vector<std::uint32_t> next(samples.cell_begin.begin(), samples.cell_begin.end() - 1);
  std::vector<const Sample*> order(found.size());
  for (const Sample& sample : found) order[next[cell_of(sample.at)]++] = &sample;
  for (const Sample* sample : order) {
    samples.points.add(sample->at);
    samples.distance.push_back(sample->distance);
  }
  samples.points.resize(found.size() + kReadBeyond);
}

}  // namespace

ShellSamples sample_shell(const TriangleMesh& mesh, const TriangleBvh& bvh, const CoverFrame& frame, float thickness,
                          std::size_t target, std::uint64_t seed, parallel::Executor& executor) {
  const Bounds box = bounds_of(mesh.vertices_m);
  const double area = mesh_area_m2(mesh) / (frame.diagonal_m * frame.diagonal_m);
  // The volume of a shell about a closed convex body of unit size is about this (Steiner's formula); creases reduce it.
  const double d = static_cast<double>(thickness);
  const double volume = area * d + 3 * d * d + 4 * d * d * d;
  const auto size = static_cast<float>(math::cbrt(volume / static_cast<double>(target)));

  ShellSamples samples;
  samples.thickness = thickness;
  samples.volume = size * size * size;
  samples.low = frame.to(box.low) - Vec3f::Constant(thickness);
  samples.cell = std::max(2 * size, 0.015F);
  const Vec3f high = frame.to(box.high) + Vec3f::Constant(thickness);
  const float extent = (high - samples.low).maxCoeff();
  int levels = 0;
  while (std::ldexp(size, levels) < extent) ++levels;
  constexpr int kTopLevels = 3;
  const int top = std::min(levels, kTopLevels);
  const std::size_t side = std::size_t{1} << static_cast<unsigned>(top);
  const float top_size = std::ldexp(size, levels - top);
  const Walk walk(bvh, frame, thickness, seed);
  std::vector<std::vector<Sample>> parts(side * side * side);
  parallel::parallel_for(executor, parts.size(), 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3f steps(static_cast<float>(i % side), static_cast<float>(i / side % side),
                        static_cast<float>(i / (side * side)));
      walk.enter(samples.low + top_size * steps, top_size, levels - top, i + 1, parts[i]);
    }
  });
  std::vector<Sample> found;
  for (const auto& part : parts) found.insert(found.end(), part.begin(), part.end());
  sort_into_cells(found, high, samples);
  return samples;
}

}  // namespace poise::geometry
