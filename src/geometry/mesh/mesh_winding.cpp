// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/mesh/mesh_volume.h"
#include "geometry/primitives/bounds.h"
#include "geometry/primitives/random.h"
#include "parallel/executor.h"

namespace poise {
namespace {

using namespace geometry;

/// Cells of the sampling grid along each axis of the box: 140,608 points. Chosen: the error of a ball's volume is 0.3
/// %.
constexpr std::size_t kSide = 52;
/// A point with a winding number above this is inside the mesh with certainty. Chosen.
constexpr double kCertainWinding = 0.75;
constexpr std::uint64_t kSeed = 0x9015e;

/// One random point in each cell, so that the sums are unbiased for any alignment of the mesh.
class SampleGrid {
 public:
  explicit SampleGrid(const Bounds& box) : low_(box.low), cell_((box.high - box.low) / static_cast<double>(kSide)) {}
  [[nodiscard]] Vec3 point(std::size_t index) const {
    Random random = Random::of(kSeed, index);
    const double x = static_cast<double>(index % kSide) + random.unit();
    const double y = static_cast<double>(index / kSide % kSide) + random.unit();
    const double z = static_cast<double>(index / (kSide * kSide)) + random.unit();
    return low_ + Vec3(x, y, z).cwiseProduct(cell_);
  }
  [[nodiscard]] double cell_m3() const { return cell_.prod(); }

 private:
  Vec3 low_, cell_;
};

enum State : std::uint8_t { kOutside, kInside, kCertain };

/// Cells that differ from a neighbour, or are inside at the edge of the box. Each contributes a standard deviation of
/// at most half a cell.
std::size_t border_cells(const std::vector<std::uint8_t>& state) {
  constexpr std::size_t kStrides[] = {1, kSide, kSide * kSide};
  std::size_t border = 0;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const bool inside = state[i] != kOutside;
    bool differs = false;
    for (const std::size_t stride : kStrides) {
      const std::size_t place = i / stride % kSide;
      differs = differs || (place > 0 ? state[i - stride] != kOutside : false) != inside;
      differs = differs || (place + 1 < kSide ? state[i + stride] != kOutside : false) != inside;
    }
    border += differs ? 1U : 0U;
  }
  return border;
}

}  // namespace

Result<SampledMass> winding_mass_properties(const TriangleMesh& mesh, int threads) {
  if (std::string wrong = why_not_threads(threads); !wrong.empty()) return bad_input(std::move(wrong));
  if (std::string wrong = why_unusable(mesh); !wrong.empty()) return bad_input(std::move(wrong));
  const TriangleBvh bvh(mesh);
  const SampleGrid grid(bounds_of(mesh.vertices_m));
  std::vector<std::uint8_t> state(kSide * kSide * kSide, kOutside);
  const auto executor = parallel::make_executor(ExecutorKind::Threads, threads);
  parallel::parallel_for(*executor, state.size(), kSide, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 point = grid.point(i);
      if (bvh.inside(point)) state[i] = std::abs(bvh.winding_number(point)) > kCertainWinding ? kCertain : kInside;
    }
  });

  SampledMass sampled;
  const auto inside = state.size() - static_cast<std::size_t>(std::ranges::count(state, kOutside));
  if (inside == 0 || !(grid.cell_m3() > 0)) return sampled;
  const auto count = static_cast<double>(inside);
  sampled.certain_share = static_cast<double>(std::ranges::count(state, kCertain)) / count;
  sampled.volume_error_m3 = std::sqrt(static_cast<double>(border_cells(state))) * grid.cell_m3();
  // Relative to the middle of the box, then to the centre of mass, so that no digits are lost far from the origin.
  const Vec3 near = bounds_of(mesh.vertices_m).center();
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (state[i] == kOutside) continue;
    const Vec3 arm = grid.point(i) - near;
    first += arm;
    second += arm * arm.transpose();
  }
  MassProperties& mass = sampled.mass;
  mass.volume_m3 = count * grid.cell_m3();
  const Vec3 center = first / count;
  mass.center_of_mass_m = near + center;
  const Mat3 about_center = mass.volume_m3 * (second / count - center * center.transpose());
  mass.inertia_m5 = about_center.trace() * Mat3::Identity() - about_center;
  return sampled;
}

}  // namespace poise
