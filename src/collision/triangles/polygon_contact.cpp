// SPDX-License-Identifier: MIT
#include "collision/triangles/polygon_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/triangles/polygon_points.h"

namespace poise::collision {
namespace {

constexpr std::uint32_t kBlock = TriangleBlock::kMost;
// Work of a block in node-pair expansions (docs/method.md): of meeting two leaves, and of their triangles. Later
// entries of a front are mostly beyond the reach that the first ones leave, so they count one. Measured: 40 to 110 ns a
// unit so counted.
constexpr std::uint32_t kUnitsPerBlock = 2;
constexpr std::uint32_t kTrianglesPerUnit = 8;
constexpr std::uint32_t kFirstEntries = 64;
// Work of what a block does in node-pair expansions, for the length of a piece: to place a triangle, to test the boxes
// of two, to look at two whose boxes meet, and at two whose planes do not part them. Measured on the meshes of
// bench_tree_query.
constexpr double kPlaceUnits = 2;
constexpr double kBoxUnits = 1.0 / 16;
constexpr double kPlaneUnits = 1;
constexpr double kFeatureUnits = 10;
// B is displaced by this share of the smaller radius, in a direction that no scene is aligned with, so that no faces
// and edges coincide exactly.
constexpr double kSleepingPair = 1e-9;
// Leaves are tested with this share of both bodies' radii added: for that displacement and for rounding.
constexpr double kSpare = 4e-9;
// Steps from surface to surface that a first guess of the gap takes at most; each is a search for the closest point.
constexpr int kGuessSteps = 4;

std::uint32_t blocks_of(std::size_t triangles) { return static_cast<std::uint32_t>((triangles + kBlock - 1) / kBlock); }

// Triangles of one side of an entry; a ball, and a plane, count as one.
std::size_t count_of(const Shape& shape, NodeIndex leaf) {
  return shape.surface == nullptr ? 1 : shape.surface->triangles_of(leaf).size();
}

std::uint32_t block_units(std::size_t a, std::size_t b, std::uint32_t place) {
  return place < kFirstEntries ? kUnitsPerBlock + static_cast<std::uint32_t>(a + b) / kTrianglesPerUnit : 1;
}

std::span<const std::uint32_t> block_of(std::span<const std::uint32_t> triangles, std::uint32_t block) {
  const std::size_t begin = std::size_t{block} * kBlock;
  return triangles.subspan(begin, std::min<std::size_t>(kBlock, triangles.size() - begin));
}

// A distance that the two surfaces are not farther apart than: from where the leaves put the contact, to and fro
// between them.
double guessed_gap_m(const PolygonProgress& progress, const PairFrame& frame, const Vec3& start) {
  const auto closest = [](const PlacedSurface& on, const Vec3& point) {
    const Vec3 body = on.rotation.transpose() * (point - on.offset_m);
    return on.point(on.surface->bvh.closest(body).point_m);
  };
  double best = std::numeric_limits<double>::infinity();
  Vec3 at = closest(progress.on_a, start);
  for (int step = 0; step < kGuessSteps; ++step) {
    const Vec3 next = closest(step % 2 == 0 ? progress.on_b : progress.on_a, at);
    const double distance = (next - at).norm();
    const bool stuck = distance > 0.9 * best || distance < polygon_softness_m(frame);
    best = std::min(best, distance);
    if (stuck) break;
    at = next;
  }
  return best;
}

// Of two leaves that both meet a triangle, the one with the least power owns a point of it. Some leaf holds every
// point, so the owner does.
bool owns(const PlacedSurface& placed, const SphereTree& tree, NodeIndex leaf, std::uint32_t triangle,
          const Vec3& point) {
  const Vec3 body = placed.rotation.transpose() * (point - placed.offset_m);
  const auto power = [&](NodeIndex node) {
    const Sphere ball = tree.sphere(node);
    return (body - ball.center_m).squaredNorm() - ball.radius_m * ball.radius_m;
  };
  const double own = power(leaf);
  for (const NodeIndex other : placed.surface->leaves_of(triangle)) {
    const double there = power(other);
    if (there < own || (there == own && other < leaf)) return false;
  }
  return true;
}

struct Ball {
  Vec3 center_m;
  double radius_m;
};

// A ball around what two balls have in common; centres `apart` from each other along `toward`, from the first to the
// second.
Ball common_part(const Ball& first, double second_radius_m, const Vec3& toward, double apart) {
  // The circle where they meet lies in a plane so far from the first centre.
  const double to_plane =
      apart > 0 ? 0.5 * (apart + (first.radius_m - second_radius_m) * (first.radius_m + second_radius_m) / apart) : -1;
  if (to_plane <= 0) return first;
  if (to_plane >= apart) return {first.center_m + toward, second_radius_m};
  const double radius2 = first.radius_m * first.radius_m - to_plane * to_plane;
  return {first.center_m + to_plane / apart * toward, std::sqrt(std::max(0.0, radius2))};
}

// One block of one entry of a front.
class Block {
 public:
  Block(const PairFrame& frame, FrontEntry entry, PolygonProgress& progress)
      : frame_(frame), entry_(entry), progress_(progress), sums_(progress.sums) {}

  // False where the piece ended within the block.
  bool meshes(std::span<const std::uint32_t> triangles_a, std::span<const std::uint32_t> triangles_b,
              double most_work) {
    TriangleBlock& block = progress_.triangles;
    if (!block.in_progress && !place_block(triangles_a, triangles_b, block)) return true;
    while (block.rows < block.count_a) {
      block.in_progress = progress_.work >= most_work;
      if (block.in_progress) return false;
      run_row(block.a[block.rows++], block);
    }
    return true;
  }

  // The ball of the other side against the triangles of this one.
  void ball(std::span<const std::uint32_t> triangles, bool of_b) {
    const PlacedSurface& on = of_b ? progress_.on_a : progress_.on_b;
    const Sphere ball = of_b ? frame_.b->tree.sphere(entry_.b) : frame_.a->tree.sphere(entry_.a);
    const Vec3 center = of_b ? progress_.on_b.point(ball.center_m) : ball.center_m;
    sinks_m_ = ball.radius_m + progress_.reach_m(frame_);
    std::array<BoxedTriangle, kBlock>& placed = progress_.triangles.a;
    const std::size_t count = near(on, triangles, {center, ball.radius_m + farthest_m()}, placed);
    for (std::size_t i = 0; i < count; ++i) triangle_and_ball(on, placed[i].triangle, center, ball.radius_m, of_b);
  }

  void plane(std::span<const std::uint32_t> triangles) {
    for (const std::uint32_t triangle : triangles) {
      const ShapeSurface::Triangle& t = progress_.on_a.surface->triangles[triangle];
      for (std::size_t k = 0; k < 3; ++k) {
        if ((t.features & (ShapeSurface::kVertex0 << k)) == 0) continue;
        const Vec3& corner = progress_.on_a.surface->vertices_m[t.vertex[k]];
        const double gap = frame_.plane_normal.dot(corner) - frame_.plane_height_m;
        if (!(gap < farthest_m())) continue;
        const FacingFeatures feature{
            gap,  -frame_.plane_normal, corner, corner, t.vertex[k], FacingFeatures::Kind::CornerFace, false, false,
            false};
        const MetPairs::Answer met = progress_.met.meet(t.vertex[k], 0);
        if (met == MetPairs::Answer::Met) continue;
        if (met == MetPairs::Answer::New || owns(progress_.on_a, frame_.a->tree, entry_.a, triangle, corner)) {
          if (gap < progress_.reach_m(frame_)) add_feature(feature, sums_);
          if (!progress_.rests) continue;
          FacingFeatures at_rest = feature;
          at_rest.point_b_m -= gap * frame_.plane_normal;
          add_facing_point(at_rest, std::uint64_t{triangle} << 32U, progress_.points);
        }
      }
    }
  }

 private:
  // Beyond this, nothing counts for anything.
  [[nodiscard]] double farthest_m() const {
    return std::max(progress_.reach_m(frame_), progress_.points_reach_m(frame_));
  }

  void note(const FacingFeatures& feature, std::uint32_t triangle_a, std::uint32_t triangle_b) {
    if (progress_.rests) add_facing_point(feature, std::uint64_t{triangle_a} << 32U | triangle_b, progress_.points);
    if (!feature.resting && feature.gap_m < progress_.reach_m(frame_)) add_feature(feature, sums_);
  }

  // Places the triangles of both leaves that may meet; are there any?
  bool place_block(std::span<const std::uint32_t> triangles_a, std::span<const std::uint32_t> triangles_b,
                   TriangleBlock& block) {
    block.rows = 0;
    block.beneath_m = progress_.rests ? points_beneath_m(frame_) : 0.0;
    const double reach = farthest_m();
    const double spare = kSpare * (frame_.a->bounding_radius_m + frame_.b->bounding_radius_m);
    const Sphere leaf_a = frame_.a->tree.sphere(entry_.a);
    const Sphere leaf_b = frame_.b->tree.sphere(entry_.b);
    const Ball ball_a{leaf_a.center_m, leaf_a.radius_m + spare};
    const Ball ball_b{progress_.on_b.point(leaf_b.center_m), leaf_b.radius_m + spare};
    const Vec3 between = ball_b.center_m - ball_a.center_m;
    const double apart = between.norm();
    if (apart > ball_a.radius_m + ball_b.radius_m + reach) return false;
    // Two points that face each other within reach lie one in each leaf, and each within reach of the other leaf.
    block.count_a =
        near(progress_.on_a, triangles_a, common_part(ball_a, ball_b.radius_m + reach, between, apart), block.a);
    if (block.count_a == 0) return false;
    block.count_b =
        near(progress_.on_b, triangles_b, common_part(ball_b, ball_a.radius_m + reach, -between, apart), block.b);
    return block.count_b > 0;
  }

  // One triangle of a against those of b.
  void run_row(const BoxedTriangle& a, const TriangleBlock& block) {
    const double reach = farthest_m();
    const Vec3 low = a.low_m.array() - reach;
    const Vec3 high = a.high_m.array() + reach;
    progress_.work += kBoxUnits * static_cast<double>(block.count_b);
    for (std::size_t j = 0; j < block.count_b; ++j) {
      const BoxedTriangle& b = block.b[j];
      if ((low.array() > b.high_m.array()).any() || (high.array() < b.low_m.array()).any()) continue;
      two_triangles(a.triangle, b.triangle);
    }
  }

  // Places the triangles that meet a ball; how many.
  std::size_t near(const PlacedSurface& on, std::span<const std::uint32_t> triangles, const Ball& ball,
                   std::array<BoxedTriangle, kBlock>& out) {
    const Vec3 body = on.rotation.transpose() * (ball.center_m - on.offset_m);
    const double radius2 = ball.radius_m * ball.radius_m;
    std::size_t count = 0;
    // A ball far away is nowhere near, whatever is lost of its contact point; one nearby loses no more than the
    // surface's own points.
    const auto x = static_cast<float>(body.x());
    const auto y = static_cast<float>(body.y());
    const auto z = static_cast<float>(body.z());
    const float radius = static_cast<float>(ball.radius_m) * (1 + 1e-6F) + on.surface->rounding_m;
    for (const std::uint32_t triangle : triangles) {
      const ShapeSurface::TriangleBounds& t = on.surface->triangle_bounds[triangle];
      const float dx = x - t.center_m[0];
      const float dy = y - t.center_m[1];
      const float dz = z - t.center_m[2];
      const float balls = radius + t.radius_m;
      if (!(dx * dx + dy * dy + dz * dz < balls * balls)) continue;
      if (std::abs(t.normal[0] * dx + t.normal[1] * dy + t.normal[2] * dz) > radius) continue;
      const geometry::TriangleCorners& corners = on.surface->bvh.corners(triangle);
      if ((geometry::closest_on_triangle(body, corners) - body).squaredNorm() > radius2) continue;
      BoxedTriangle& boxed = out[count++];
      place(on, triangle, boxed.triangle);
      const auto& corner = boxed.triangle.corner_m;
      boxed.low_m =
          corner[0].cwiseMin(corner[1]).cwiseMin(corner[2]).cwiseMax(Vec3(ball.center_m.array() - ball.radius_m));
      boxed.high_m =
          corner[0].cwiseMax(corner[1]).cwiseMax(corner[2]).cwiseMin(Vec3(ball.center_m.array() + ball.radius_m));
    }
    progress_.work += kPlaceUnits * static_cast<double>(count);
    return count;
  }

  void two_triangles(const PlacedTriangle& a, const PlacedTriangle& b) {
    const double apart = farthest_m();
    const double beneath_m = progress_.triangles.beneath_m;
    const double reach = std::max(apart, beneath_m);
    const PlaneSides sides = plane_sides(a, b);
    progress_.work += kPlaneUnits;
    if (beyond(sides, reach)) return;
    const MetPairs::Answer met = progress_.met.meet(a.index, b.index);
    if (met == MetPairs::Answer::Met) return;
    progress_.work += kFeatureUnits;
    const bool unlisted = met == MetPairs::Answer::NoRoom;
    const auto counts = [&](const Vec3& on_a, const Vec3& on_b) {
      return !unlisted || (owns(progress_.on_a, frame_.a->tree, entry_.a, a.index, on_a) &&
                           owns(progress_.on_b, frame_.b->tree, entry_.b, b.index, on_b));
    };
    if (const auto segment = crossing(progress_.on_a, a, progress_.on_b, b, sides)) {
      const Vec3 middle = 0.5 * (segment->from_m + segment->to_m);
      if (counts(middle, middle)) add_segment(*segment, a.index, b.index, sums_);
    }
    if (reach <= 0) return;
    FeatureList features;
    const std::size_t count = facing_features(progress_.on_a, a, progress_.on_b, b, sides, apart, features, beneath_m);
    for (std::size_t k = 0; k < count; ++k) {
      if (features[k].gap_m < apart && counts(features[k].point_a_m, features[k].point_b_m))
        note(features[k], a.index, b.index);
    }
  }

  void triangle_and_ball(const PlacedSurface& on, const PlacedTriangle& t, const Vec3& center, double radius_m,
                         bool of_b) {
    const double sign = of_b ? 1.0 : -1.0;
    if (on.surface->solid) {
      const double above = t.normal.dot(center - t.corner_m[0]);
      // Whether it is inside is asked once, of the nearest face, when all have been seen.
      if (above < 0 && -above <= sinks_m_ && above - radius_m > sums_.sunk.gap_m && over_face(t, center)) {
        add_sunk_ball({above - radius_m, sign * t.normal, center, center - above * t.normal, of_b}, sums_);
      }
    }
    const double reach = farthest_m();
    FeatureList features;
    const std::size_t count = features_facing_point(on, t, center, radius_m + reach, features);
    if (count == 0) return;
    const MetPairs::Answer met = progress_.met.meet(t.index, of_b ? entry_.b : entry_.a);
    if (met == MetPairs::Answer::Met) return;
    for (std::size_t k = 0; k < count; ++k) {
      FacingFeatures& feature = features[k];
      feature.gap_m -= radius_m;
      if (!(feature.gap_m < reach)) continue;
      if (met == MetPairs::Answer::NoRoom &&
          !owns(on, of_b ? frame_.a->tree : frame_.b->tree, of_b ? entry_.a : entry_.b, t.index, feature.point_a_m)) {
        continue;
      }
      feature.point_b_m -= radius_m * feature.normal;
      feature.normal *= sign;
      if (!of_b) std::swap(feature.point_a_m, feature.point_b_m);
      note(feature, of_b ? t.index : entry_.a, of_b ? entry_.b : t.index);
    }
  }

  const PairFrame& frame_;
  FrontEntry entry_;
  PolygonProgress& progress_;
  PolygonSums& sums_;
  double sinks_m_ = 0;  // how deep the centre of a ball may lie beneath a face
};

// Blocks of an entry; none where one of its leaves has no surface.
struct Blocks {
  std::uint32_t a = 0, b = 0;
  [[nodiscard]] std::uint32_t count() const { return a * b; }
};
Blocks blocks_of(const PairFrame& frame, FrontEntry entry) {
  return {blocks_of(count_of(*frame.a, entry.a)), blocks_of(count_of(*frame.b, entry.b))};
}

// Does one block; false where the piece ended within it.
bool run_block(const PairFrame& frame, FrontEntry entry, std::uint32_t number, double most_work,
               PolygonProgress& progress) {
  Block block(frame, entry, progress);
  const Blocks blocks = blocks_of(frame, entry);
  std::span<const std::uint32_t> a;
  std::span<const std::uint32_t> b;
  if (frame.a->surface != nullptr) a = block_of(frame.a->surface->triangles_of(entry.a), number / blocks.b);
  if (frame.b->surface != nullptr) b = block_of(frame.b->surface->triangles_of(entry.b), number % blocks.b);
  if (!progress.triangles.in_progress)
    progress.work +=
        block_units(std::max<std::size_t>(a.size(), 1), std::max<std::size_t>(b.size(), 1), progress.place);
  if (!frame.with_plane() && frame.a->surface != nullptr && frame.b->surface != nullptr)
    return block.meshes(a, b, most_work);
  if (frame.with_plane()) {
    block.plane(a);
  } else if (frame.b->surface == nullptr) {
    block.ball(a, true);
  } else {
    block.ball(b, false);
  }
  return true;
}

// The sum over the blocks of an entry: whole blocks, and the last ones, which are smaller. One where there are none.
std::uint64_t entry_units(const Shape& a, const Shape& b, FrontEntry entry, std::uint32_t place) {
  const auto parts = [](std::size_t count) {
    return std::array<std::size_t, 3>{count / kBlock, count % kBlock, std::size_t{count % kBlock == 0 ? 0U : 1U}};
  };
  const auto [whole_a, rest_a, last_a] = parts(count_of(a, entry.a));
  const auto [whole_b, rest_b, last_b] = parts(count_of(b, entry.b));
  const std::uint64_t units = std::uint64_t{whole_a} * whole_b * block_units(kBlock, kBlock, place) +
                              std::uint64_t{whole_a} * last_b * block_units(kBlock, rest_b, place) +
                              std::uint64_t{last_a} * whole_b * block_units(rest_a, kBlock, place) +
                              std::uint64_t{last_a} * last_b * block_units(rest_a, rest_b, place);
  return std::max<std::uint64_t>(units, 1);
}

}  // namespace

MetPairs::Answer MetPairs::meet(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t key = (std::uint64_t{a} << 32U) | b;
  // Fibonacci hashing (Knuth, vol. 3, 6.4): the high bits of the product.
  auto place = static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ULL) >> 54U);
  for (; keys_[place] != kNone; place = (place + 1) % kSlots) {
    if (keys_[place] == key) return Answer::Met;
  }
  if (count_ == kMost) return Answer::NoRoom;
  keys_[place] = key;
  ++count_;
  return Answer::New;
}

void allow_polygons(const Shape& a, const Shape& b, Level max_level, PairLevel& pair) {
  if ((a.surface == nullptr && b.surface == nullptr) || deepest_level(a, b, kMaxTreeDepth) > max_level) return;
  pair.polygons = true;
  ++pair.deepest;
  if (pair.next_is_polygons()) pair.next_units = polygon_units(a, b, {}, SegmentRef{});
}

std::uint32_t polygon_units(const Shape& a, const Shape& b, std::span<const FrontPool> pools, SegmentRef front) {
  std::uint64_t units = 0;
  std::uint32_t place = 0;
  for_each_segment(pools, front, [&](std::span<const FrontEntry> entries) {
    for (const FrontEntry entry : entries) units += entry_units(a, b, entry, place++);
  });
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(units, std::numeric_limits<std::uint32_t>::max()));
}

void begin_polygons(const PairFrame& frame, const Mat3& rotation_a, const PairLevel& pair, const LevelContact& found,
                    PolygonProgress& progress, bool rests) {
  progress.reading = pair.front;
  progress.roots = pair.front.none();
  progress.on_a.surface = frame.a->surface.get();
  progress.on_b.surface = frame.b->surface.get();
  progress.on_b.rotation = frame.rotation;
  const double size = std::min(frame.a->bounding_radius_m, frame.b->bounding_radius_m);
  progress.rests = rests;
  progress.points.clear(frame.with_plane() ? frame.a->bounding_radius_m : size);
  progress.on_b.offset_m = frame.offset_m + kSleepingPair * size * Vec3(0.61, 0.73, -0.31);
  progress.sums.softness_m = polygon_softness_m(frame);
  progress.most_m = frame.margin_m;
  const bool meshes = progress.on_a.surface != nullptr && progress.on_b.surface != nullptr;
  if (!meshes || !found.contact.present || reach_of_sums_m(frame, progress.sums, 0) >= frame.margin_m) return;
  const Vec3 start = rotation_a.transpose() * found.contact.arm_m;
  progress.most_m = std::min(frame.margin_m, guessed_gap_m(progress, frame, start));
}

double PolygonProgress::reach_m(const PairFrame& frame) const { return reach_of_sums_m(frame, sums, most_m); }

double PolygonProgress::points_reach_m(const PairFrame& frame) const {
  if (!rests) return 0;
  return collision::points_reach_m(frame, sums.crossed ? 0.0 : std::min(sums.least_gap_m, most_m));
}

Quantum run_polygons(const PairFrame& frame, std::span<const FrontPool> pools, std::uint32_t units,
                     PolygonProgress& progress) {
  constexpr FrontEntry kRoots[1] = {{0, 0}};
  for (progress.work = 0; progress.work < units;) {
    FrontSegment segment{0, 1, {}};
    std::span<const FrontEntry> entries = kRoots;
    if (!progress.roots) {
      const FrontPool& source = pools[segment_worker(progress.reading)];
      segment = source.segment(segment_index(progress.reading));
      entries = source.entries(segment);
    }
    const FrontEntry entry = entries[progress.offset];
    const std::uint32_t blocks = blocks_of(frame, entry).count();
    if (blocks == 0) {
      progress.work += 1;
    } else {
      if (!run_block(frame, entry, progress.block, units, progress)) return Quantum::More;
      progress.triangles.in_progress = false;
      ++progress.block;
    }
    if (progress.block < blocks) continue;
    progress.block = 0;
    ++progress.place;
    if (++progress.offset < segment.count) continue;
    progress.offset = 0;
    if (segment.next.none()) return Quantum::Complete;
    progress.reading = segment.next;
  }
  return Quantum::More;
}

void publish_polygons(const PairFrame& frame, const Mat3& rotation_a, PolygonProgress& progress, PairLevel& pair,
                      LevelContact& found) {
  found.contact = make_polygon_contact(frame, progress.on_a, progress.on_b, progress.sums, found.contact, rotation_a);
  found.manifold_points = {};
  found.points_due = false;
  if (progress.rests) {
    found.manifold_points = manifold_points_of(frame, rotation_a, progress.on_a, progress.on_b, progress.sums,
                                               found.contact, progress.points);
  }
  ++pair.level;
  pair.apart = !found.contact.present;
}

}  // namespace poise::collision
