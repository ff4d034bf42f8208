// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "collision/front/front.h"
#include "collision/front/pair_frame.h"
#include "collision/manifold/contact_sums.h"
#include "collision/manifold/manifold_point.h"
#include "poise/types.h"

namespace poise::collision {

/// The deepest completed level of a pair in this frame and its result.
struct PairLevel {
  Level level = 0;
  Level deepest = 0;      ///< deepest level that refines the pair further
  bool polygons = false;  ///< the deepest level is that of the polygons, after all levels of the trees
  bool apart = false;     ///< no two nodes of this level are nearer than the margin
  bool nearly = false;    ///< some that were not would be with PairFrame::nearness.wide_m more
  SegmentRef front;       ///< none at level 0: the two roots
  SegmentRef points;      ///< entries that the contact points come from: the front, or the nearest of a large one
  std::uint32_t front_entries = 1;  ///< = expansions that the next level of the trees costs
  std::uint32_t point_entries = 0;  ///< of `points`
  std::uint32_t next_units = 1;     ///< what the next level costs, in node-pair expansions
  [[nodiscard]] bool refinable() const { return !apart && level < deepest; }
  [[nodiscard]] bool next_is_polygons() const { return polygons && level + 1 == deepest; }
  [[nodiscard]] bool by_polygons() const { return polygons && level == deepest; }
  /// Is the level after the next one of the trees too?
  [[nodiscard]] bool passes_next() const { return level + (polygons ? 2 : 1) < deepest; }
};

/// The contact that this level found, if any. Separate from PairLevel because most pairs of a calm scene have none.
struct LevelContact {
  PairContact contact;             ///< used for impacts
  ManifoldPoints manifold_points;  ///< for resting contact
  bool points_due = false;         ///< manifold points are not made yet
  bool gaps_only = false;          ///< of `contact` no more is known than separations: the next level follows at once
  double reach_m = 0;              ///< all that is nearer than this is in the front of the level
  bool narrowed = false;           ///< and much that is farther away
};

/// Both, for callers that refine a single pair.
struct SinglePair : PairLevel, LevelContact {};

/// Segments in the making.
struct SegmentChain {
  SegmentRef first, last;
  std::uint32_t entries = 0;
};

/// A level in progress: expanded by one worker at a time in bounded pieces.
struct LevelProgress {
  SegmentRef reading;           ///< of the front being expanded
  std::uint32_t offset = 0;     ///< entries of it that are done
  SegmentChain front, nearest;  ///< new
  bool sampled = false;         ///< see sample_points
  bool last = false;            ///< likewise: the new front is only counted
  bool nearly = false;          ///< as PairLevel::nearly
  bool narrows = false;         ///< the front that is read holds much that is too far away
  ContactSums sums;
  FrontPool::Mark mark{};  ///< of the worker's pool when the level was begun
};

enum class Quantum : std::uint8_t {
  More,      ///< the level is not complete yet
  Complete,  ///< the level may be published
  Full,      ///< the pool is full: the level must be discarded whole
};

/// The deepest level of the trees that refining two shapes can reach; b may be a plane.
Level deepest_level(const Shape& a, const Shape& b, Level max_level);

/// A root sphere in the world, and the centre of mass of its body.
struct PlacedRoot {
  const Shape* shape = nullptr;
  Vec3 center_m = Vec3::Zero();
  Vec3 mass_center_m = Vec3::Zero();
};
/// Estimated depth of the surface beneath the root sphere at a contact of level 0; the estimated separation is larger
/// by that of both bodies.
double coarsest_lift_m(const Shape& shape);
/// The contact of level 0: that of the two root spheres, whatever their distance.
PairContact coarsest_contact(const PlacedRoot& a, const PlacedRoot& b);
/// The same of a root sphere and the half-space normal . x <= height, world frame. The centre of mass stays above it.
PairContact coarsest_plane_contact(const PlacedRoot& a, const Vec3& normal, double height_m);

LevelProgress begin_level(const PairLevel& pair, const LevelContact& found, const FrontPool& pool);
inline LevelProgress begin_level(const SinglePair& pair, const FrontPool& pool) {
  return begin_level(pair, pair, pool);
}
/// Before the first piece of a level: where the pair looks far and its front is large, contact points come from the
/// nearest children of each entry. `last`: no level and no contact model will read the new front, which is then only
/// counted.
void sample_points(const PairFrame& frame, const PairLevel& pair, bool last, LevelProgress& progress);

/// Expands at most `units` entries into the pool of `worker`. Bounded, allocates nothing.
Quantum run_quantum(const PairFrame& frame, std::span<FrontPool> pools, int worker, std::uint32_t units,
                    LevelProgress& progress);

/// Stores a complete level in the pair. If it is nearer than the margin its manifold points are due: made below, once
/// no deeper level follows.
void publish_level(const PairFrame& frame, const Mat3& rotation_a, const LevelProgress& progress, PairLevel& pair,
                   LevelContact& found);

/// The manifold points of a level in progress, made in bounded pieces.
struct PointsProgress {
  ManifoldClusters clusters;
  SegmentRef reading;                                    ///< of the pair's front
  std::uint32_t offset = 0;                              ///< entries of it that are taken
  std::array<FrontEntry, NodeContacts::kLanes> block{};  ///< the first `in_block` are taken; others name nodes too
  std::size_t in_block = 0;
};
PointsProgress begin_points(const PairFrame& frame, const PairLevel& pair, const LevelContact& found);
/// What the points of so many entries cost, in node-pair expansions.
std::uint32_t points_units(std::uint32_t front_entries);
/// Takes the entries that `units` pay for. Bounded, allocates nothing.
Quantum run_points(const PairFrame& frame, std::span<const FrontPool> pools, std::uint32_t units,
                   PointsProgress& progress);
void publish_points(PointsProgress& progress, LevelContact& found);
/// All in one piece.
void make_points(const PairFrame& frame, std::span<const FrontPool> pools, const PairLevel& pair, LevelContact& found);

/// The contact as a manifold of one point, in the frame of a.
ManifoldPoint impact_point(const PairContact& contact, const Mat3& rotation_a);

/// Calls visit(span of entries) over the pair's front, in order.
template <class Visit>
void for_each_segment(std::span<const FrontPool> pools, SegmentRef front, Visit&& visit);

inline SegmentRef segment_ref(int worker, std::uint32_t index) {
  return {static_cast<std::uint32_t>(worker) << kSegmentIndexBits | index};
}
inline std::uint32_t segment_worker(SegmentRef ref) { return ref.bits >> kSegmentIndexBits; }
inline std::uint32_t segment_index(SegmentRef ref) { return ref.bits & ((1U << kSegmentIndexBits) - 1U); }

template <class Visit>
void for_each_segment(std::span<const FrontPool> pools, SegmentRef front, Visit&& visit) {
  if (front.none()) {
    const FrontEntry roots{0, 0};
    visit(std::span<const FrontEntry>(&roots, 1));
    return;
  }
  for (SegmentRef ref = front; !ref.none();) {
    const FrontPool& pool = pools[segment_worker(ref)];
    const FrontSegment& segment = pool.segment(segment_index(ref));
    visit(pool.entries(segment));
    ref = segment.next;
  }
}

}  // namespace poise::collision
