// SPDX-License-Identifier: MIT
#include "collision/triangles/polygon_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace poise::collision {
namespace {

// Triangles of a leaf that are tested at once against a ball or a plane.
constexpr std::uint32_t kBlock = 64;
// Work in node-pair expansions, for the length of a piece. Of a block of triangles against a ball or a plane: of
// meeting a leaf, of each of its triangles, and of placing one.
constexpr std::uint32_t kUnitsPerBlock = 2;
constexpr std::uint32_t kTrianglesPerUnit = 8;
constexpr double kPlaceUnits = 2;
// Of two meshes: to go one node deeper in both, to compare the triangles that were found, to place two and look whether
// they cross, and to look at their features. Measured on the meshes of bench_tree_query.
constexpr double kSplitUnits = 2;
constexpr double kCompareUnits = 8;
constexpr double kPlaneUnits = 3;
constexpr double kFeatureUnits = 5;
// Of the contact of a pair, where its surfaces cross or not, and of a row of the search for deeper points.
constexpr double kCrossingUnits = 256;
constexpr double kContactUnits = 32;
constexpr double kDeeperUnits = 40;
// What two meshes cost is not known before: most of it goes to the triangles near the first touch.
constexpr std::uint32_t kUnitsOfMeshes = 1536;
// B is displaced by this share of the smaller radius, in a direction that no scene is aligned with, so that no faces
// and edges coincide exactly.
constexpr double kSleepingPair = 1e-9;
// Steps from surface to surface that a first guess of the gap takes at most; each is a search for the closest point.
constexpr int kGuessSteps = 2;

std::uint32_t block_units(std::size_t triangles) {
  return kUnitsPerBlock + static_cast<std::uint32_t>(triangles) / kTrianglesPerUnit;
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

// Beyond this, nothing counts for anything.
double farthest_m(const PairFrame& frame, const PolygonProgress& progress) {
  return std::max(progress.reach_m(frame), progress.points_reach_m(frame));
}

void add_facing(const PairFrame& frame, const FacingFeatures& feature, std::uint32_t triangle_a,
                std::uint32_t triangle_b, PolygonProgress& progress) {
  if (progress.rests) add_facing_point(feature, std::uint64_t{triangle_a} << 32U | triangle_b, progress.points);
  if (!feature.resting && feature.gap_m < progress.reach_m(frame)) add_feature(feature, progress.sums);
}

// The triangles of a leaf against a ball or a plane, as many as a block has.
class Block {
 public:
  Block(const PairFrame& frame, FrontEntry entry, PolygonProgress& progress)
      : frame_(frame), entry_(entry), progress_(progress), sums_(progress.sums) {}

  // The ball of the other side against the triangles of this one.
  void ball(std::span<const std::uint32_t> triangles, bool of_b) {
    const PlacedSurface& on = of_b ? progress_.on_a : progress_.on_b;
    const Sphere ball = of_b ? frame_.b->tree.sphere(entry_.b) : frame_.a->tree.sphere(entry_.a);
    const Vec3 center = of_b ? progress_.on_b.point(ball.center_m) : ball.center_m;
    sinks_m_ = ball.radius_m + progress_.reach_m(frame_);
    std::array<PlacedTriangle, kBlock> placed;
    const std::size_t count = near(on, triangles, center, ball.radius_m + farthest_m(frame_, progress_), placed);
    for (std::size_t i = 0; i < count; ++i) triangle_and_ball(on, placed[i], center, ball.radius_m, of_b);
  }

  void plane(std::span<const std::uint32_t> triangles) {
    for (const std::uint32_t triangle : triangles) {
      const ShapeSurface::Triangle& t = progress_.on_a.surface->triangles[triangle];
      for (std::size_t k = 0; k < 3; ++k) {
        if ((t.features & (ShapeSurface::kVertex0 << k)) == 0) continue;
        const Vec3& corner = progress_.on_a.surface->vertices_m[t.vertex[k]];
        const double gap = frame_.plane_normal.dot(corner) - frame_.plane_height_m;
        if (!(gap < farthest_m(frame_, progress_))) continue;
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
  // Places the triangles that meet a ball; how many.
  std::size_t near(const PlacedSurface& on, std::span<const std::uint32_t> triangles, const Vec3& center_m,
                   double radius_m, std::array<PlacedTriangle, kBlock>& out) {
    const Vec3 body = on.rotation.transpose() * (center_m - on.offset_m);
    const double radius2 = radius_m * radius_m;
    std::size_t count = 0;
    // A ball far away is nowhere near, whatever is lost of its contact point; one nearby loses no more than the
    // surface's own points.
    const auto x = static_cast<float>(body.x());
    const auto y = static_cast<float>(body.y());
    const auto z = static_cast<float>(body.z());
    const float radius = static_cast<float>(radius_m) * (1 + 1e-6F) + on.surface->rounding_m;
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
      place(on, triangle, out[count++]);
    }
    progress_.work += kPlaceUnits * static_cast<double>(count);
    return count;
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
    const double reach = farthest_m(frame_, progress_);
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
      add_facing(frame_, feature, of_b ? t.index : entry_.a, of_b ? entry_.b : t.index, progress_);
    }
  }

  const PairFrame& frame_;
  FrontEntry entry_;
  PolygonProgress& progress_;
  PolygonSums& sums_;
  double sinks_m_ = 0;  // how deep the centre of a ball may lie beneath a face
};

// The leaf of the one shape that has triangles.
std::span<const std::uint32_t> triangles_of(const Shape& a, const Shape& b, FrontEntry entry) {
  return a.surface != nullptr ? a.surface->triangles_of(entry.a) : b.surface->triangles_of(entry.b);
}

void run_block(const PairFrame& frame, FrontEntry entry, std::span<const std::uint32_t> triangles,
               PolygonProgress& progress) {
  Block block(frame, entry, progress);
  progress.work += block_units(triangles.size());
  if (frame.with_plane()) {
    block.plane(triangles);
  } else {
    block.ball(triangles, frame.b->surface == nullptr);
  }
}

SurfaceReach reach_of(const PairFrame& frame, const PolygonProgress& progress) {
  return {farthest_m(frame, progress), std::min(progress.beneath_m, points_beneath_m(frame, progress.looked_at))};
}

// A pair of triangles of two meshes that the descent has found.
void look_at(const PairFrame& frame, const SurfaceDescent::Candidate& found, const SurfaceReach& reach,
             PolygonProgress& progress) {
  const PlacedTriangle& a = progress.placed_a.get(progress.on_a, found.a);
  const PlacedTriangle& b = progress.placed_b.get(progress.on_b, found.b);
  const PlaneSides sides = plane_sides(a, b);
  progress.work += kPlaneUnits;
  if (found.may_cross) {
    if (const auto segment = crossing(a, b, sides)) add_segment(*segment, a.index, b.index, progress.sums);
  }
  if (!found.may_face || beyond(sides, std::max(reach.apart_m, reach.beneath_m))) return;
  progress.work += kFeatureUnits;
  FeatureList features;
  const std::size_t count =
      facing_features(progress.on_a, a, progress.on_b, b, sides, reach.apart_m, features, reach.beneath_m);
  for (std::size_t k = 0; k < count; ++k) {
    if (features[k].gap_m < reach.apart_m) add_facing(frame, features[k], a.index, b.index, progress);
  }
}

// Goes on until all triangles were looked through or the piece is done; true when all were.
bool run_meshes(const PairFrame& frame, std::uint32_t units, PolygonProgress& progress) {
  SurfaceReach reach = reach_of(frame, progress);
  while (progress.work < units) {
    const SurfaceDescent::Step step = progress.descent.step(reach);
    if (step == SurfaceDescent::Step::Done) return true;
    progress.work += step == SurfaceDescent::Step::Split ? kSplitUnits : kCompareUnits;
    if (step == SurfaceDescent::Step::Split) continue;
    progress.looked_at += progress.descent.near();
    for (const SurfaceDescent::Candidate& found : progress.descent.candidates()) {
      reach = reach_of(frame, progress);
      look_at(frame, found, reach, progress);
    }
    reach = reach_of(frame, progress);
  }
  return false;
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
  if (a.surface != nullptr && b.surface != nullptr) return kUnitsOfMeshes;
  std::uint64_t units = 0;
  for_each_segment(pools, front, [&](std::span<const FrontEntry> entries) {
    for (const FrontEntry entry : entries) {
      const std::size_t triangles = triangles_of(a, b, entry).size();
      units += std::uint64_t{triangles / kBlock} * block_units(kBlock) + block_units(triangles % kBlock);
    }
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
  progress.rotation_a = rotation_a;
  progress.contact = found.contact;
  progress.points.clear(frame.with_plane() ? frame.a->bounding_radius_m : size);
  progress.on_b.offset_m = frame.offset_m + kSleepingPair * size * Vec3(0.61, 0.73, -0.31);
  progress.sums.softness_m = polygon_softness_m(frame);
  progress.most_m = frame.margin_m;
  progress.beneath_m = rests ? points_beneath_m(frame) : 0.0;
  if (!progress.meshes()) return;
  progress.descent.begin(progress.on_a, progress.on_b);
  if (!found.contact.present || reach_of_sums_m(frame, progress.sums, 0) >= frame.margin_m) return;
  const Vec3 start = rotation_a.transpose() * found.contact.arm_m;
  progress.most_m = std::min(frame.margin_m, guessed_gap_m(progress, frame, start));
}

double PolygonProgress::reach_m(const PairFrame& frame) const { return reach_of_sums_m(frame, sums, most_m); }

double PolygonProgress::points_reach_m(const PairFrame& frame) const {
  if (!rests) return 0;
  return collision::points_reach_m(frame, sums.crossed ? 0.0 : std::min(sums.least_gap_m, most_m), looked_at);
}

namespace {

// The same for a mesh and balls or a plane, by the front of leaves.
bool run_leaves(const PairFrame& frame, std::span<const FrontPool> pools, std::uint32_t units,
                PolygonProgress& progress) {
  constexpr FrontEntry kRoots[1] = {{0, 0}};
  while (progress.work < units) {
    FrontSegment segment{0, 1, {}};
    std::span<const FrontEntry> entries = kRoots;
    if (!progress.roots) {
      const FrontPool& source = pools[segment_worker(progress.reading)];
      segment = source.segment(segment_index(progress.reading));
      entries = source.entries(segment);
    }
    const FrontEntry entry = entries[progress.offset];
    const std::span<const std::uint32_t> triangles = triangles_of(*frame.a, *frame.b, entry);
    run_block(frame, entry, block_of(triangles, progress.block), progress);
    if (++progress.block * std::size_t{kBlock} < triangles.size()) continue;
    progress.block = 0;
    if (++progress.offset < segment.count) continue;
    progress.offset = 0;
    if (segment.next.none()) return true;
    progress.reading = segment.next;
  }
  return false;
}

}  // namespace

Quantum run_polygons(const PairFrame& frame, std::span<const FrontPool> pools, std::uint32_t units,
                     PolygonProgress& progress) {
  using Stage = PolygonStage;
  PolygonProgress& p = progress;
  p.work = 0;
  while (p.stage != Stage::Done && p.work < units) {
    switch (p.stage) {
      case Stage::Triangles:
        if (p.meshes() ? run_meshes(frame, units, p) : run_leaves(frame, pools, units, p)) p.stage = Stage::Contact;
        break;
      case Stage::Contact:
        p.contact = make_polygon_contact(frame, p.on_a, p.on_b, p.sums, p.contact, p.rotation_a);
        p.work += p.sums.crossed ? kCrossingUnits : kContactUnits;
        p.stage = p.rests ? Stage::Deeper : Stage::Done;
        if (p.rests) begin_deeper(frame, p.on_a, p.on_b, p.sums, p.contact, p.looked_at, p.deeper, p.points);
        break;
      case Stage::Deeper:
        p.work += kDeeperUnits;
        if (!look_deeper(p.on_a, p.on_b, p.descent, p.deeper, p.points)) p.stage = Stage::Points;
        break;
      case Stage::Points:
        p.work += kContactUnits;
        p.manifold_points = manifold_points_of(frame, p.rotation_a, p.contact, p.looked_at, p.points);
        p.stage = Stage::Done;
        break;
      case Stage::Done:
        break;
    }
  }
  return p.stage == Stage::Done ? Quantum::Complete : Quantum::More;
}

void publish_polygons(const PolygonProgress& progress, PairLevel& pair, LevelContact& found) {
  found.contact = progress.contact;
  found.manifold_points = progress.manifold_points;
  found.points_due = false;
  ++pair.level;
  pair.apart = !found.contact.present;
}

}  // namespace poise::collision
