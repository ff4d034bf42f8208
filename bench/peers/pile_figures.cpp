// SPDX-License-Identifier: MIT
#include "peers/pile_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace poise::bench {
namespace {

using Cell = std::array<std::int64_t, 3>;

struct PlacedSphere {
  Cell cell;
  std::uint32_t body;
  Vec3 center_m;
  double radius_m;
};

void count(double overlap_m, PileFigures& figures) {
  if (!(overlap_m > 0)) return;
  ++figures.overlaps;
  figures.mean_overlap_m += overlap_m;  // the sum until all overlaps are added
  figures.greatest_overlap_m = std::max(figures.greatest_overlap_m, overlap_m);
}

// Two overlapping spheres are in the same cell or in neighbouring ones: a cell is as wide as the largest sphere.
void count_pairs(std::span<const PlacedSphere> spheres, PileFigures& figures) {
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const PlacedSphere& a = spheres[i];
    for (std::int64_t dx = 0; dx <= 1; ++dx) {
      for (std::int64_t dy = dx == 0 ? 0 : -1; dy <= 1; ++dy) {
        // Along z the cells of a column are contiguous.
        const bool same_column = dx == 0 && dy == 0;
        const Cell first{a.cell[0] + dx, a.cell[1] + dy, a.cell[2] - 1};
        const Cell last{first[0], first[1], a.cell[2] + 1};
        auto at = same_column ? spheres.begin() + static_cast<std::ptrdiff_t>(i) + 1
                              : std::ranges::lower_bound(spheres, first, {}, &PlacedSphere::cell);
        for (; at != spheres.end() && at->cell <= last; ++at) {
          if (at->body != a.body) count(a.radius_m + at->radius_m - (at->center_m - a.center_m).norm(), figures);
        }
      }
    }
  }
}

}  // namespace

PileFigures pile_figures(const PileScene& scene, std::span<const BodyState> states) {
  PileFigures figures;
  if (states.empty()) return figures;
  for (const BodyState& state : states) {
    figures.finite = figures.finite && state.position_m.allFinite() && state.orientation.coeffs().allFinite() &&
                     state.velocity_mps.allFinite() && state.angular_velocity_radps.allFinite() &&
                     state.position_m.cwiseAbs().maxCoeff() < 1e9;
  }
  if (!figures.finite) return figures;
  double cell_m = 0;
  for (const Sphere& sphere : scene.spheres) cell_m = std::max(cell_m, 2 * sphere.radius_m);
  std::vector<PlacedSphere> spheres;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const BodyState& state = states[i];
    figures.mean_height_m += state.position_m.z();
    figures.mean_speed_mps += state.velocity_mps.norm();
    figures.greatest_speed_mps = std::max(figures.greatest_speed_mps, state.velocity_mps.norm());
    const auto behind = [&](const PileScene::Wall& wall) { return wall.normal.dot(state.position_m) < wall.offset_m; };
    if (std::ranges::any_of(scene.walls, behind)) ++figures.outside;
    for (const Sphere& sphere : scene.spheres) {
      const Vec3 center_m = state.position_m + state.orientation * sphere.center_m;
      const auto place = [&](double x_m) { return static_cast<std::int64_t>(std::floor(x_m / cell_m)); };
      spheres.push_back({{place(center_m.x()), place(center_m.y()), place(center_m.z())},
                         static_cast<std::uint32_t>(i),
                         center_m,
                         sphere.radius_m});
      for (const PileScene::Wall& wall : scene.walls)
        count(wall.offset_m + sphere.radius_m - wall.normal.dot(center_m), figures);
    }
  }
  std::ranges::stable_sort(spheres, {}, &PlacedSphere::cell);
  count_pairs(spheres, figures);
  const auto bodies = static_cast<double>(states.size());
  figures.mean_height_m /= bodies;
  figures.mean_speed_mps /= bodies;
  if (figures.overlaps > 0) figures.mean_overlap_m /= static_cast<double>(figures.overlaps);
  return figures;
}

}  // namespace poise::bench
