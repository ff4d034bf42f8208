// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "collision/triangles/convex_gap.h"
#include "geometry/shape/shape_surface.h"
#include "poise/shape.h"

namespace poise::collision {

/// A shape at a pose relative to some origin.
struct StandingShape {
  const Shape* shape = nullptr;
  Mat3 turn = Mat3::Identity();  ///< body frame to world
  Vec3 at_m = Vec3::Zero();      ///< centre of mass

  [[nodiscard]] Vec3 point(const Vec3& body_m) const { return turn * body_m + at_m; }
  [[nodiscard]] bool leaf(NodeIndex node) const { return shape->tree.child_count[node] == 0; }
};

/// A ball around a part or a node, with the distance of its centre from the centre of mass, which is how far turning
/// can carry it.
struct BoundingBall {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
  double arm_m = 0;
};

inline BoundingBall ball_of(const StandingShape& s, const Vec3& center_m, double radius_m) {
  return {s.point(center_m), radius_m, center_m.norm()};
}
inline BoundingBall ball_of(const StandingShape& s, NodeIndex node) {
  const Sphere sphere = s.shape->tree.sphere(node);
  return ball_of(s, sphere.center_m, sphere.radius_m);
}

/// Calls visit(index, part, ball around it) for the convex parts of a leaf: the triangles that meet it, or its own
/// ball. A part has the same index in each leaf.
template <class Visit>
void for_parts(const StandingShape& s, NodeIndex leaf, Visit&& visit) {
  ConvexPart part;
  if (!s.shape->surface) {
    const BoundingBall ball = ball_of(s, leaf);
    part.corner_m[0] = ball.center_m;
    part.radius_m = ball.radius_m;
    visit(std::uint32_t{leaf}, part, ball);
    return;
  }
  const ShapeSurface& surface = *s.shape->surface;
  part.corners = 3;
  for (const std::uint32_t index : surface.triangles_of(leaf)) {
    const ShapeSurface::Triangle& t = surface.triangles[index];
    const auto place = [&] {
      for (std::size_t k = 0; k < 3; ++k) part.corner_m[k] = s.point(surface.vertices_m[t.vertex[k]]);
      return part;
    };
    visit(index, place, ball_of(s, t.center_m, t.radius_m));
  }
}

/// Pairs of parts that a descent has met. A large triangle is in many leaves: of two boxes of twelve triangles each
/// pair would be computed a dozen times. May forget a pair, so that it is met again.
class MetParts {
 public:
  void clear() { keys_.fill(kNone); }
  /// Whether the pair was not met since clear(), as far as is known.
  [[nodiscard]] bool first(std::uint32_t a, std::uint32_t b) {
    const std::uint64_t key = (std::uint64_t{a} << 32U) | b;
    std::uint64_t& place = keys_[(a * 61U + b) % kPlaces];
    return std::exchange(place, key) != key;
  }

 private:
  static constexpr std::size_t kPlaces = 512;  // chosen: 4 KB
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::array<std::uint64_t, kPlaces> keys_;
};

/// A simultaneous descent of two trees, or of one against a plane, to the parts that may improve the result, best bound
/// first, with bounded work.
///
/// Measure has: `double of_balls(a, b)` and `double to_plane(a)`, lower bounds of what `of_parts` and `part_to_plane`
/// compute for anything inside; `void of_parts(a, b)`, `void part_to_plane(a)`, which store the best; and `double
/// best()`, beyond which nothing matters. A bound that is not below it is left out.
class Descent {
 public:
  explicit Descent(std::uint32_t max_node_pairs) : left_(max_node_pairs) {}
  [[nodiscard]] std::uint32_t left() const { return left_; }

  /// The whole descent. Returns infinity, or where the work ran out the least bound of what was left.
  template <class Measure>
  double run(const StandingShape& a, const StandingShape& b, Measure& measure) {
    const bool with_plane = b.shape->kind == ShapeKind::Plane;
    met_.clear();
    std::array<Waiting, kStack> stack;
    std::size_t waiting = 1;
    stack[0] = {0, 0, with_plane ? measure.to_plane(ball_of(a, NodeIndex{0})) : bound(a, 0, b, 0, measure)};
    while (waiting > 0) {
      if (left_ == 0) return least_of(std::span(stack).first(waiting));
      const Waiting top = stack[--waiting];
      if (top.bound >= measure.best()) continue;
      if (a.leaf(top.a) && (with_plane || b.leaf(top.b))) {
        if (with_plane) {
          leaf_to_plane(a, top.a, measure);
        } else if (!leaves(a, top.a, b, top.b, measure)) {
          return std::min(top.bound, least_of(std::span(stack).first(waiting)));
        }
        continue;
      }
      const bool split_a = with_plane || b.leaf(top.b) ||
                           (!a.leaf(top.a) && a.shape->tree.radius_m[top.a] >= b.shape->tree.radius_m[top.b]);
      const SphereTree& tree = split_a ? a.shape->tree : b.shape->tree;
      const NodeIndex parent = split_a ? top.a : top.b;
      const std::size_t first = waiting;
      for (std::uint32_t k = 0; k < tree.child_count[parent]; ++k) {
        const NodeIndex child = tree.first_child[parent] + k;
        Waiting next{split_a ? child : top.a, split_a ? top.b : child, 0};
        spend();
        next.bound = with_plane ? measure.to_plane(ball_of(a, next.a)) : bound(a, next.a, b, next.b, measure);
        if (next.bound >= measure.best()) continue;
        std::size_t place = waiting++;
        for (; place > first && stack[place - 1].bound < next.bound; --place) stack[place] = stack[place - 1];
        stack[place] = next;
      }
    }
    return std::numeric_limits<double>::infinity();
  }

 private:
  struct Waiting {
    NodeIndex a, b;
    double bound;
  };
  // Each split leaves at most seven siblings behind, and a pair is split at most once a level on each side.
  static constexpr std::size_t kStack = 2 * (kMaxTreeDepth + 1) * kTreeBranching + 1;

  void spend() { left_ -= left_ > 0 ? 1 : 0; }

  static double least_of(std::span<const Waiting> stack) {
    double least = std::numeric_limits<double>::infinity();
    for (const Waiting& w : stack) least = std::min(least, w.bound);
    return least;
  }

  template <class Measure>
  static double bound(const StandingShape& a, NodeIndex na, const StandingShape& b, NodeIndex nb, Measure& measure) {
    return measure.of_balls(ball_of(a, na), ball_of(b, nb));
  }

  static const ConvexPart& placed(const ConvexPart& part) { return part; }
  template <class MakePart>
  static ConvexPart placed(const MakePart& make_part) {
    return make_part();
  }

  // False where the work ran out.
  template <class Measure>
  bool leaves(const StandingShape& a, NodeIndex na, const StandingShape& b, NodeIndex nb, Measure& measure) {
    const BoundingBall whole_b = ball_of(b, nb);
    for_parts(a, na, [&](std::uint32_t index_a, const auto& part_a, const BoundingBall& ball_a) {
      spend();
      if (left_ == 0 || measure.of_balls(ball_a, whole_b) >= measure.best()) return;
      const ConvexPart placed_a = placed(part_a);
      // What its ball excludes is not charged: it would count otherwise for b as a, by how many parts each has.
      for_parts(b, nb, [&](std::uint32_t index_b, const auto& part_b, const BoundingBall& ball_b) {
        if (left_ == 0 || measure.of_balls(ball_a, ball_b) >= measure.best()) return;
        if (!met_.first(index_a, index_b)) return;
        spend();
        measure.of_parts(placed_a, placed(part_b));
      });
    });
    return left_ > 0;
  }

  template <class Measure>
  void leaf_to_plane(const StandingShape& a, NodeIndex na, Measure& measure) {
    for_parts(a, na, [&](std::uint32_t, const auto& part, const BoundingBall& ball) {
      spend();
      if (measure.to_plane(ball) < measure.best()) measure.part_to_plane(placed(part));
    });
  }

  std::uint32_t left_;
  MetParts met_;
};

}  // namespace poise::collision
