// SPDX-License-Identifier: MIT
#include "geometry/mesh/mesh_orient.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/mesh/mesh_edges.h"
#include "geometry/primitives/bounds.h"

namespace poise::geometry {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Uses = std::span<const EdgeUse>;

/// An open piece whose volume closed by cones is below this share of area times diagonal is a sheet, which has no
/// outside. Chosen; a ball has 0.1.
constexpr double kSheetShare = 0.003;
/// A closed piece below this share of the cube of its diagonal has only the volume of rounding errors.
constexpr double kFlatShare = 1e-12;
/// Number of a piece's vertices that must lie in another one for the whole to count as inside it. Chosen.
constexpr std::size_t kProbes = 8;

void turn_over(Triangle& triangle) { std::swap(triangle[1], triangle[2]); }

/// Disjoint sets of triangles that store for each member whether it is reversed relative to its leader. Invariant:
/// above_ leads to the leader in at most log2(n) steps, since the smaller set joins the larger.
class TurnedSets {
 public:
  explicit TurnedSets(std::size_t count) : above_(count), turned_(count, 0), size_(count, 1) {
    std::iota(above_.begin(), above_.end(), 0U);
  }
  [[nodiscard]] std::uint32_t leader(std::uint32_t i) const {
    while (above_[i] != i) i = above_[i];
    return i;
  }
  [[nodiscard]] bool turned(std::uint32_t i) const {
    bool turned = false;
    for (; above_[i] != i; i = above_[i]) turned = turned != (turned_[i] != 0);
    return turned;
  }
  [[nodiscard]] std::uint32_t size(std::uint32_t leader) const { return size_[leader]; }
  /// Joins the sets of a and b so that they are reversed relative to each other, or not. Does nothing if they are in
  /// one set.
  void join(std::uint32_t a, std::uint32_t b, bool against) {
    std::uint32_t small = leader(a);
    std::uint32_t large = leader(b);
    if (small == large) return;
    if (size_[small] > size_[large]) std::swap(small, large);
    turned_[small] = (against != turned(a)) != turned(b) ? 1 : 0;
    above_[small] = large;
    size_[large] += size_[small];
  }

 private:
  std::vector<std::uint32_t> above_;
  std::vector<std::uint8_t> turned_;
  std::vector<std::uint32_t> size_;
};

/// Which triangles must be reversed so that neighbours agree; the smaller part of each patch is reversed.
std::vector<std::uint8_t> turned_against_neighbours(std::size_t triangles, Uses uses) {
  // In the order of the edges, which does not depend on the triangles' orientation, so that a second call finds the
  // same.
  TurnedSets patches(triangles);
  for_each_edge(uses, [&](Uses edge) {
    if (edge.size() == 2) patches.join(edge[0].triangle, edge[1].triangle, edge[0].direction == edge[1].direction);
  });
  std::vector<std::uint32_t> turned_count(triangles, 0);
  std::vector<std::uint8_t> first_turned(triangles, 2);  // 2 until the first triangle of the patch is visited
  std::vector<std::uint8_t> turned(triangles, 0);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::uint32_t leader = patches.leader(t);
    turned[t] = patches.turned(t) ? 1 : 0;
    turned_count[leader] += turned[t];
    if (first_turned[leader] == 2) first_turned[leader] = turned[t];
  }
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::uint32_t leader = patches.leader(t);
    const std::uint64_t twice = 2 * std::uint64_t{turned_count[leader]};
    const bool turned_gives_way =
        twice < patches.size(leader) || (twice == patches.size(leader) && first_turned[leader] == 0);
    if (!turned_gives_way) turned[t] ^= 1;
  }
  return turned;
}

bool disagrees(Uses edge) { return edge.size() > 1 && edge_balance(edge) != 0; }

/// Reverses single triangles; returns their number.
std::size_t agree_with_neighbours(std::vector<Triangle>& triangles) {
  std::vector<EdgeUse> uses = edge_uses(triangles);
  std::vector<std::uint8_t> turned = turned_against_neighbours(triangles.size(), uses);
  if (std::ranges::count(turned, 1) == 0) return 0;
  // Compares the inconsistent edges of each connected part before and after.
  JoinedSets parts(triangles.size());
  for_each_edge(uses, [&](Uses edge) {
    for (const EdgeUse& use : edge) parts.join(edge[0].triangle, use.triangle);
  });
  std::vector<std::int64_t> gain(triangles.size(), 0);
  for_each_edge(uses, [&](Uses edge) { gain[parts.leader(edge[0].triangle)] += disagrees(edge) ? 1 : 0; });
  for (EdgeUse& use : uses) use.direction = turned[use.triangle] != 0 ? -use.direction : use.direction;
  for_each_edge(uses, [&](Uses edge) { gain[parts.leader(edge[0].triangle)] -= disagrees(edge) ? 1 : 0; });
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (turned[t] == 0 || gain[parts.leader(t)] <= 0) continue;
    turn_over(triangles[t]);
    ++count;
  }
  return count;
}

/// A part of a mesh with its own outside.
struct Piece {
  std::vector<std::uint32_t> triangles;
  Bounds box;
  bool closed = true;
  double volume_m3 = 0;  ///< signed; an open piece is closed by cones
  bool inside_out = false;
};

/// Patches of triangles (joined over edges of two triangles). Patches that are not closed are joined where they meet at
/// edges of more than two.
std::vector<std::uint32_t> piece_of_triangles(std::size_t triangles, Uses uses) {
  JoinedSets patches(triangles);
  for_each_edge(uses, [&](Uses edge) {
    if (edge.size() == 2) patches.join(edge[0].triangle, edge[1].triangle);
  });
  std::vector<std::uint8_t> open(triangles, 0);
  std::vector<std::pair<std::uint32_t, std::int32_t>> balances;
  for_each_edge(uses, [&](Uses edge) {
    balances.clear();
    for (const EdgeUse& use : edge) balances.emplace_back(patches.leader(use.triangle), use.direction);
    std::ranges::sort(balances);
    for (std::size_t begin = 0; begin < balances.size();) {
      std::size_t end = begin;
      std::int32_t balance = 0;
      for (; end < balances.size() && balances[end].first == balances[begin].first; ++end)
        balance += balances[end].second;
      if (balance != 0) open[balances[begin].first] = 1;
      begin = end;
    }
  });
  JoinedSets pieces(triangles);
  for (std::uint32_t t = 0; t < triangles; ++t) pieces.join(t, patches.leader(t));
  for_each_edge(uses, [&](Uses edge) {
    if (edge.size() < 3) return;
    const EdgeUse* first = nullptr;
    for (const EdgeUse& use : edge) {
      if (open[patches.leader(use.triangle)] == 0) continue;
      if (first == nullptr) first = &use;
      pieces.join(first->triangle, use.triangle);
    }
  });
  std::vector<std::uint32_t> piece(triangles);
  for (std::uint32_t t = 0; t < triangles; ++t) piece[t] = pieces.leader(t);
  return piece;
}

/// A piece is closed if each of its edges is balanced. The volume is computed about the middle of the unbalanced ones.
void measure_piece(const TriangleMesh& mesh, Piece& piece) {
  std::vector<Triangle> own;
  own.reserve(piece.triangles.size());
  for (const std::uint32_t t : piece.triangles) own.push_back(mesh.triangles[t]);
  Vec3 rim = Vec3::Zero();
  double rim_length_m = 0;
  const std::vector<EdgeUse> uses = edge_uses(own);
  for_each_edge(uses, [&](Uses edge) {
    if (edge_balance(edge) == 0) return;
    piece.closed = false;
    const Vec3& a = mesh.vertices_m[edge[0].low];
    const Vec3& b = mesh.vertices_m[edge[0].high];
    rim_length_m += (b - a).norm();
    rim += (b - a).norm() * 0.5 * (a + b);
  });
  for (const Triangle& t : own) {
    for (const std::uint32_t v : t) piece.box.add(mesh.vertices_m[v]);
  }
  const Vec3 from = rim_length_m > 0 ? Vec3(rim / rim_length_m) : piece.box.center();
  double area_m2 = 0;
  for (const Triangle& t : own) {
    const Vec3 a = mesh.vertices_m[t[0]] - from;
    const Vec3 b = mesh.vertices_m[t[1]] - from;
    const Vec3 c = mesh.vertices_m[t[2]] - from;
    piece.volume_m3 += a.dot(b.cross(c)) / 6;
    area_m2 += 0.5 * (b - a).cross(c - a).norm();
  }
  const double diagonal_m = (piece.box.high - piece.box.low).norm();
  const double least_m3 = diagonal_m * (piece.closed ? kFlatShare * (diagonal_m * diagonal_m) : kSheetShare * area_m2);
  piece.inside_out = piece.volume_m3 < -least_m3;
  if (std::abs(piece.volume_m3) <= least_m3) piece.closed = false;  // encloses no volume, so nothing lies in it
}

std::vector<Piece> pieces_of(const TriangleMesh& mesh) {
  const std::vector<EdgeUse> uses = edge_uses(mesh.triangles);
  const std::vector<std::uint32_t> leader = piece_of_triangles(mesh.triangles.size(), uses);
  std::vector<std::uint32_t> place(mesh.triangles.size(), 0);
  std::vector<Piece> pieces;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (leader[t] == t) {
      place[t] = static_cast<std::uint32_t>(pieces.size());
      pieces.emplace_back();
    }
    pieces[place[leader[t]]].triangles.push_back(t);
  }
  for (Piece& piece : pieces) measure_piece(mesh, piece);
  return pieces;
}

/// Whether a whole piece lies in a closed one, tested at a few of its vertices.
bool lies_in(const TriangleMesh& mesh, const Piece& piece, const TriangleBvh& closed) {
  const std::size_t step = std::max<std::size_t>(1, piece.triangles.size() / kProbes);
  for (std::size_t i = 0; i < piece.triangles.size(); i += step) {
    if (!closed.inside(mesh.vertices_m[mesh.triangles[piece.triangles[i]][0]])) return false;
  }
  return true;
}

TriangleMesh triangles_alone(const TriangleMesh& mesh, const std::vector<std::uint32_t>& triangles) {
  TriangleMesh alone;
  for (const std::uint32_t t : triangles) {
    const auto first = static_cast<std::uint32_t>(alone.vertices_m.size());
    for (const std::uint32_t v : mesh.triangles[t]) alone.vertices_m.push_back(mesh.vertices_m[v]);
    alone.triangles.push_back({first, first + 1, first + 2});
  }
  return alone;
}

/// For each piece the outermost closed one that it lies in, else itself.
std::vector<std::size_t> outermost(const TriangleMesh& mesh, const std::vector<Piece>& pieces) {
  std::vector<std::size_t> outer(pieces.size());
  std::iota(outer.begin(), outer.end(), std::size_t{0});
  // Sweeps from low to high along x, with a list of the closed pieces whose box has not ended yet.
  std::vector<std::size_t> order = outer;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return pieces[i].box.low.x(); });
  std::vector<std::size_t> reaching;
  std::vector<std::unique_ptr<TriangleBvh>> made(pieces.size());
  for (std::size_t place = 0; place < order.size(); ++place) {
    const std::size_t i = order[place];
    const Bounds& box = pieces[i].box;
    std::erase_if(reaching, [&](std::size_t j) { return pieces[j].box.high.x() < box.low.x(); });
    for (const std::size_t j : reaching) {
      const Bounds& around = pieces[j].box;
      const bool within =
          (around.low.array() <= box.low.array()).all() && (around.high.array() >= box.high.array()).all();
      const bool larger = outer[i] == i || std::abs(pieces[j].volume_m3) > std::abs(pieces[outer[i]].volume_m3);
      if (!within || !larger) continue;
      if (made[j] == nullptr) {
        made[j] = std::make_unique<TriangleBvh>(triangles_alone(mesh, pieces[j].triangles));
      }
      if (lies_in(mesh, pieces[i], *made[j])) outer[i] = j;
    }
    if (pieces[i].closed) reaching.push_back(i);
  }
  // Decided by sample points, so of three nested pieces the inner two may not name the same outermost one; each step
  // leads to a larger piece.
  for (std::size_t& outermost_one : outer) {
    while (outer[outermost_one] != outermost_one) outermost_one = outer[outermost_one];
  }
  return outer;
}

}  // namespace

Orientation orient_triangles(TriangleMesh& mesh) {
  Orientation done;
  done.triangles_turned = agree_with_neighbours(mesh.triangles);
  const std::vector<Piece> pieces = pieces_of(mesh);
  if (std::ranges::none_of(pieces, &Piece::inside_out)) return done;
  const std::vector<std::size_t> outer = outermost(mesh, pieces);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (!pieces[outer[i]].inside_out) continue;
    for (const std::uint32_t t : pieces[i].triangles) turn_over(mesh.triangles[t]);
    ++done.pieces_turned;
  }
  done.all_turned = done.pieces_turned == pieces.size();
  return done;
}

}  // namespace poise::geometry
