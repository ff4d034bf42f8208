// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/cover/solid_cells.h"

#include <algorithm>
#include <cmath>

#include "geometry/mesh/mesh_volume.h"

namespace poise::geometry {
namespace {

/// Most cells of a grid; bounds memory to about 60 MB. For an open mesh every corner is tested, hence fewer. Chosen.
constexpr double kMostCells = 2e7;
constexpr double kMostCellsOfOpen = 5e5;

struct Grid {
  Vec3 origin;
  double cell_m = 0;
  std::array<std::size_t, 3> cells{};

  [[nodiscard]] double plane(int axis, std::size_t i) const { return origin[axis] + cell_m * static_cast<double>(i); }
  [[nodiscard]] std::size_t cell_index(std::size_t x, std::size_t y, std::size_t z) const {
    return (z * cells[1] + y) * cells[0] + x;
  }
  [[nodiscard]] std::size_t corner_index(std::size_t x, std::size_t y, std::size_t z) const {
    return (z * (cells[1] + 1) + y) * (cells[0] + 1) + x;
  }
  [[nodiscard]] std::size_t cell_count() const { return cells[0] * cells[1] * cells[2]; }
  [[nodiscard]] std::size_t corner_count() const { return (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1); }
};

/// Chooses a grid over the mesh with about `target` cells that meet the solid. The estimate is volume / cell^3 inner
/// cells, and about 1.5 cells for each cell face's area of surface. The planes are shifted by irrational shares of a
/// cell, so that they do not coincide with the round coordinates common in meshes.
Grid choose_grid(const TriangleMesh& mesh, std::size_t target, double most_cells) {
  const Bounds box = bounds_of(mesh.vertices_m);
  const Vec3 size = box.high - box.low;
  const double area = mesh_area_m2(mesh);
  const double volume = std::abs(mesh_volume(mesh).volume_m3);
  const auto too_fine = [&](double h) {
    const Vec3 cells = (size / h).array() + 2;
    return volume / (64 * h * h * h) + 2 * area / (h * h) > static_cast<double>(target) || cells.prod() > most_cells;
  };
  double fine = size.maxCoeff() * 1e-3;
  double coarse = size.maxCoeff();
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (fine + coarse);
    (too_fine(middle) ? fine : coarse) = middle;
  }
  Grid grid;
  grid.cell_m = coarse;
  const Vec3 shift(0.4142135623730951, 0.7320508075688772, 0.2360679774997897);
  grid.origin = box.low - coarse * shift;
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = std::floor((box.high[axis] - grid.origin[axis]) / coarse) + 1;
    grid.cells[static_cast<std::size_t>(axis)] = static_cast<std::size_t>(cells);
  }
  return grid;
}

using Polygon = std::vector<Vec3>;

/// Cuts a convex polygon by the plane x[axis] = at; corners on the plane belong to both parts. The point on an edge is
/// computed from its lower end, so that two triangles that share the edge get the same bits.
void cut(const Polygon& polygon, int axis, double at, Polygon& below, Polygon& above) {
  below.clear();
  above.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& a = polygon[i];
    const Vec3& b = polygon[(i + 1) % polygon.size()];
    if (a[axis] <= at) below.push_back(a);
    if (a[axis] >= at) above.push_back(a);
    if ((a[axis] < at && b[axis] > at) || (a[axis] > at && b[axis] < at)) {
      const Vec3& low = a[axis] < b[axis] ? a : b;
      const Vec3& high = a[axis] < b[axis] ? b : a;
      Vec3 crossing = low + (at - low[axis]) / (high[axis] - low[axis]) * (high - low);
      crossing[axis] = at;
      below.push_back(crossing);
      above.push_back(crossing);
    }
  }
}

struct CellPiece {
  std::size_t cell;
  std::size_t first;
  std::size_t count;
};

/// Pieces of one chunk of triangles in the cells, in the order of the triangles.
struct Pieces {
  std::vector<Vec3> points;
  std::vector<CellPiece> pieces;
};

/// Cuts a polygon into slabs along an axis, and each slab along the next axis; the last cut gives the pieces of cells.
void cut_into_cells(const Grid& grid, Polygon polygon, int axis, std::array<std::size_t, 3> cell, Pieces& out) {
  if (axis == 3) {
    out.pieces.push_back({grid.cell_index(cell[0], cell[1], cell[2]), out.points.size(), polygon.size()});
    out.points.insert(out.points.end(), polygon.begin(), polygon.end());
    return;
  }
  double low = polygon[0][axis];
  double high = low;
  for (const Vec3& p : polygon) {
    low = std::min(low, p[axis]);
    high = std::max(high, p[axis]);
  }
  const auto a = static_cast<std::size_t>(axis);
  const double guess =
      std::clamp(std::floor((low - grid.origin[axis]) / grid.cell_m), 0.0, static_cast<double>(grid.cells[a] - 1));
  auto slab = static_cast<std::size_t>(guess);
  // The division may be off by one near a plane; comparing with the planes is exact.
  while (slab > 0 && grid.plane(axis, slab) >= low) --slab;
  Polygon below;
  Polygon above;
  for (; slab < grid.cells[a] && !polygon.empty(); ++slab) {
    cell[a] = slab;
    const double top = grid.plane(axis, slab + 1);
    if (slab + 1 == grid.cells[a] || top > high) {
      cut_into_cells(grid, std::move(polygon), axis + 1, cell, out);
      return;
    }
    cut(polygon, axis, top, below, above);
    if (!below.empty()) cut_into_cells(grid, below, axis + 1, cell, out);
    std::swap(polygon, above);
  }
}

Pieces clip_all(const TriangleMesh& mesh, const Grid& grid, parallel::Executor& executor) {
  constexpr std::size_t kCellGrain = 256;
  std::vector<Pieces> chunks((mesh.triangles.size() + kCellGrain - 1) / kCellGrain);
  parallel::parallel_for(executor, mesh.triangles.size(), kCellGrain, [&](std::size_t begin, std::size_t end, int) {
    Pieces& out = chunks[begin / kCellGrain];
    for (std::size_t i = begin; i < end; ++i) {
      const auto& t = mesh.triangles[i];
      cut_into_cells(grid, {mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]}, 0, {}, out);
    }
  });
  Pieces all;
  for (const Pieces& chunk : chunks) {
    const std::size_t base = all.points.size();
    all.points.insert(all.points.end(), chunk.points.begin(), chunk.points.end());
    for (const CellPiece& piece : chunk.pieces) all.pieces.push_back({piece.cell, base + piece.first, piece.count});
  }
  std::ranges::stable_sort(all.pieces, {}, &CellPiece::cell);
  return all;
}

/// Which grid corners are inside (or on the surface, to rounding). Along a line of corners the result for a closed mesh
/// can only change between two corners whose edge a triangle may cross, so only corners beside cells with triangles are
/// tested.
std::vector<std::uint8_t> inside_corners(const Grid& grid, const std::vector<std::uint8_t>& has_surface,
                                         const TriangleBvh& bvh, double near_m, parallel::Executor& executor) {
  std::vector<std::uint8_t> inside(grid.corner_count(), 0);
  const std::size_t lines = (grid.cells[1] + 1) * (grid.cells[2] + 1);
  parallel::parallel_for(executor, lines, 8, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t line = begin; line < end; ++line) {
      const std::size_t y = line % (grid.cells[1] + 1);
      const std::size_t z = line / (grid.cells[1] + 1);
      const auto crossed = [&](std::size_t x) {
        for (std::size_t beside = 0; beside < 4; ++beside) {
          const std::size_t cy = y - (beside & 1U);
          const std::size_t cz = z - (beside >> 1U);  // below 0 wraps to a huge number, which the range test excludes
          if (cy < grid.cells[1] && cz < grid.cells[2] && has_surface[grid.cell_index(x, cy, cz)] != 0) return true;
        }
        return false;
      };
      bool state = false;  // the first corner of a line lies outside the box of the mesh
      bool known = true;
      for (std::size_t x = 0; x <= grid.cells[0]; ++x) {
        if (x > 0 && (!bvh.closed() || crossed(x - 1))) known = false;
        if (!known) {
          const Vec3 corner(grid.plane(0, x), grid.plane(1, y), grid.plane(2, z));
          state = bvh.inside(corner);
          // A corner on the surface counts as inside for this point alone, because an additional point never uncovers
          // anything; the next corner is tested again.
          const bool touching = bvh.closest(corner, near_m * near_m).squared_distance_m2 < near_m * near_m;
          inside[grid.corner_index(x, y, z)] = state || touching ? 1 : 0;
          known = !touching;
          continue;
        }
        inside[grid.corner_index(x, y, z)] = state ? 1 : 0;
      }
    }
  });
  return inside;
}

bool before(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

void close_cell(SolidCells& cells) {
  const std::size_t first = cells.begin.back();
  const auto begin = cells.points_m.begin() + static_cast<std::ptrdiff_t>(first);
  std::sort(begin, cells.points_m.end(), before);  // equal points are the same bits, so their order does not matter
  cells.points_m.erase(std::unique(begin, cells.points_m.end()), cells.points_m.end());
  if (cells.points_m.size() == first) return;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = first; i < cells.points_m.size(); ++i) sum += cells.points_m[i];
  cells.middle_m.emplace_back(sum / static_cast<double>(cells.points_m.size() - first));
  cells.begin.push_back(cells.points_m.size());
}

/// Combines the cells' points. A block of cells that are completely inside becomes one cell, since none of it is near
/// the surface.
class CellGatherer {
  // Invariant: cells_.begin holds the first point of each finished cell, then the number of points.
 public:
  CellGatherer(const Grid& grid, const Pieces& pieces, const std::vector<std::uint8_t>& has_surface,
               const std::vector<std::uint8_t>& inside, bool closed)
      : grid_(grid), pieces_(pieces), has_surface_(has_surface), inside_(inside), closed_(closed) {
    cells_.begin.push_back(0);
  }

  SolidCells gather() {
    for (std::size_t z = 0; z < grid_.cells[2]; z += kLargestBlock) {
      for (std::size_t y = 0; y < grid_.cells[1]; y += kLargestBlock) {
        for (std::size_t x = 0; x < grid_.cells[0]; x += kLargestBlock) gather_block({x, y, z}, kLargestBlock);
      }
    }
    return std::move(cells_);
  }

 private:
  using GridIndex = std::array<std::size_t, 3>;

  [[nodiscard]] bool full(const GridIndex& at) const {
    if (has_surface_[grid_.cell_index(at[0], at[1], at[2])] != 0) return false;
    return inside_[grid_.corner_index(at[0], at[1], at[2])] != 0 && corners_inside(at, 1) == 8;
  }
  [[nodiscard]] std::size_t corners_inside(const GridIndex& at, std::size_t size) const {
    std::size_t count = 0;
    for (std::size_t c = 0; c < 8; ++c) count += inside_[corner(at, size, c)];
    return count;
  }
  [[nodiscard]] std::size_t corner(const GridIndex& at, std::size_t size, std::size_t c) const {
    return grid_.corner_index(at[0] + size * (c & 1U), at[1] + size * (c >> 1U & 1U), at[2] + size * (c >> 2U));
  }
  void add_corner(const GridIndex& at, std::size_t size, std::size_t c) {
    cells_.points_m.emplace_back(grid_.plane(0, at[0] + size * (c & 1U)), grid_.plane(1, at[1] + size * (c >> 1U & 1U)),
                                 grid_.plane(2, at[2] + size * (c >> 2U)));
  }

  void gather_block(const GridIndex& at, std::size_t size) {
    if (at[0] >= grid_.cells[0] || at[1] >= grid_.cells[1] || at[2] >= grid_.cells[2]) return;
    if (size == 1) return gather_cell(at);
    bool all = at[0] + size <= grid_.cells[0] && at[1] + size <= grid_.cells[1] && at[2] + size <= grid_.cells[2];
    for (std::size_t i = 0; i < size * size * size && all; ++i) {
      all = full({at[0] + i % size, at[1] + i / size % size, at[2] + i / (size * size)});
    }
    if (all) {
      for (std::size_t c = 0; c < 8; ++c) add_corner(at, size, c);
      close_cell(cells_);
      return;
    }
    const std::size_t half = size / 2;
    for (std::size_t c = 0; c < 8; ++c)
      gather_block({at[0] + half * (c & 1U), at[1] + half * (c >> 1U & 1U), at[2] + half * (c >> 2U)}, half);
  }

  void gather_cell(const GridIndex& at) {
    const std::size_t cell = grid_.cell_index(at[0], at[1], at[2]);
    const std::size_t in = corners_inside(at, 1);
    // Around holes of an open mesh the inside may end without a triangle; then all corners of the cell are included.
    const bool has_surface = has_surface_[cell] != 0;
    if (has_surface) {
      for (auto piece = std::ranges::lower_bound(pieces_.pieces, cell, {}, &CellPiece::cell);
           piece != pieces_.pieces.end() && piece->cell == cell; ++piece) {
        const auto first = pieces_.points.begin() + static_cast<std::ptrdiff_t>(piece->first);
        cells_.points_m.insert(cells_.points_m.end(), first, first + static_cast<std::ptrdiff_t>(piece->count));
      }
    }
    if (in > 0) {
      for (std::size_t c = 0; c < 8; ++c) {
        if (!closed_ || inside_[corner(at, 1, c)] != 0) add_corner(at, 1, c);
      }
    }
    close_cell(cells_);
  }

  static constexpr std::size_t kLargestBlock = 4;
  const Grid& grid_;
  const Pieces& pieces_;
  const std::vector<std::uint8_t>& has_surface_;
  const std::vector<std::uint8_t>& inside_;
  bool closed_;
  SolidCells cells_;
};

}  // namespace

SolidCells cut_into_cells(const TriangleMesh& mesh, const TriangleBvh& bvh, std::size_t target,
                          parallel::Executor& executor) {
  const Grid grid = choose_grid(mesh, target, bvh.closed() ? kMostCells : kMostCellsOfOpen);
  const Pieces pieces = clip_all(mesh, grid, executor);
  std::vector<std::uint8_t> has_surface(grid.cell_count(), 0);
  for (const CellPiece& piece : pieces.pieces) has_surface[piece.cell] = 1;
  const std::vector<std::uint8_t> inside = inside_corners(grid, has_surface, bvh, 1e-9 * mesh.diagonal_m(), executor);
  return CellGatherer(grid, pieces, has_surface, inside, bvh.closed()).gather();
}

}  // namespace poise::geometry
