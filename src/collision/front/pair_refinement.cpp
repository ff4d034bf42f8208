// SPDX-License-Identifier: MIT
#include "collision/front/pair_refinement.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "poise_assert.h"

namespace poise::collision {
namespace {

constexpr FrontEntry kRoots[1] = {{0, 0}};

// At level 0 bodies nest deeper than the mean protrusion says: by this share of the difference to the largest
// protrusion. Chosen: at 0 and at 0.25 settled piles stand up to 34 and 36 % off their height at full levels, here
// within 20 (docs/accuracy.md, "levels change").
constexpr double kNesting = 0.125;

// Contacts nearer than this many skins (a quarter of the smaller body's radius, chosen) in similar directions form one
// contact point.
constexpr double kClusterSkins = 50;

// A level of a fast pair is searched this many skins (a twentieth of the radius) beyond what the nearest surfaces are
// apart at most. Chosen: docs/performance.md, "What was tried and lost".
constexpr double kReachSkins = 10;
// A front that was searched farther than this share of what matters is looked through again before it is expanded: a
// test of eight entries takes half as long as the expansion of one.
constexpr double kNarrowed = 0.8;
// Contact points of a front come from all its entries. Of a pair that looks farther than kReachSkins, where more than
// this were expanded into the front, they come from the nearest children of each: these stand closer to each other than
// contact points. A pair at rest looks two skins far.
constexpr std::uint32_t kSampledEntries = 64;

// Entries whose contact points take as long as one expansion. Measured: bench_refinement.
constexpr std::uint32_t kPointsOfUnit = 8;

// A wrench of one contact, with the gaps of level 0. The moment about b is left to the caller.
PairContact impact_contact(const SphereContact& touch, const Vec3& arm_m, double lift_m, double most_m) {
  PairContact contact;
  contact.direction = touch.normal;
  contact.arm_m = arm_m;
  contact.moment_a_m = arm_m.cross(touch.normal);
  contact.spheres_m = touch.gap_m;
  contact.estimated_separation_m = touch.gap_m + lift_m;
  contact.certain_separation_m = touch.gap_m + most_m;
  contact.present = true;
  return contact;
}

// Entries that are expanded between two looks at what they have found.
constexpr std::size_t kAtOnce = 16;
// Entries that are expanded into one list of the nearest.
constexpr std::uint32_t kSampledRun = 64;

// What to search where the separation is `upper_m` at most: what is farther from touching matters in a later step, when
// it is nearer.
double narrowed_reach_m(const PairFrame& frame, double upper_m) {
  if (!frame.fast) return frame.margin_m;
  return std::min(frame.margin_m, std::max(0.0, upper_m) + kReachSkins * frame.skin_m);
}

// What is left to search while a level is summed up.
double reach_of(const PairFrame& frame, const ContactSums& sums) {
  return narrowed_reach_m(frame, std::min(sums.fitted.cores_m, sums.fitted_near.cores_m));
}

// Expands a run and sums up what is close, in parts whose lists of close entries stay small. Each part is searched no
// farther than those before it let expect.
Expansion expand_close(const PairFrame& frame, std::span<const FrontEntry> run, std::span<FrontEntry> room,
                       std::span<FrontEntry> nearest, LevelProgress& progress) {
  EntryBuffer<kAtOnce * kTreeBranching * kTreeBranching> close_buffer;
  EntryBuffer<kAtOnce> narrowed_buffer;
  const std::span<FrontEntry> close = close_buffer.entries();
  const std::span<FrontEntry> narrowed = narrowed_buffer.entries();
  Expansion all;
  while (all.consumed < run.size()) {
    const auto whole = run.subspan(all.consumed, std::min(kAtOnce, run.size() - all.consumed));
    Nearness nearness = frame.nearness;
    nearness.inflation_m -= static_cast<float>(frame.margin_m - reach_of(frame, progress.sums));
    // Bodies that are near for sure are not separated, nearly or not; and one nearly overlapping pair is enough.
    if (nearness.inflation_m < frame.nearness.inflation_m || progress.nearly || all.nearly) nearness.wide_m = 0;
    std::span<const FrontEntry> part = whole;
    if (progress.narrows) part = narrowed.first(narrow_front(frame.trees(), nearness.inflation_m, whole, narrowed));
    const std::span<FrontEntry> near = progress.last ? room : room.subspan(all.hits);
    Expansion made = expand(frame, nearness, part, {near, close, nearest.subspan(all.nearest), progress.last});
    std::uint32_t listed = made.hits;
    if (progress.last) {
      // Nobody else reads the front: it is listed only if it counts here, over and over again in the same place.
      const Expansion again = counts_near(made.close, progress.sums) ? expand(frame, nearness, part, {near, close, {}})
                                                                     : Expansion{made.consumed};
      made.consumed = again.consumed;
      listed = again.hits;
    }
    add_close(frame, near.first(listed), close.first(made.close), progress.sums);
    all.hits += made.hits;
    all.nearest += made.nearest;
    all.nearly = all.nearly || made.nearly;
    if (made.consumed < part.size()) break;
    all.consumed += static_cast<std::uint32_t>(whole.size());
  }
  return all;
}

// A segment of the first entries in the room of a pool.
void append(std::uint32_t entries, int worker, std::span<FrontPool> pools, SegmentChain& chain) {
  if (entries == 0) return;
  const SegmentRef ref = segment_ref(worker, pools[static_cast<std::size_t>(worker)].keep(entries));
  if (chain.last.none()) {
    chain.first = ref;
  } else {
    pools[segment_worker(chain.last)].segment(segment_index(chain.last)).next = ref;
  }
  chain.last = ref;
  chain.entries += entries;
}

// Expands a run of entries into one segment of a list; entries expanded, or fewer when there is no room.
std::uint32_t expand_run(const PairFrame& frame, std::span<const FrontEntry> run, int worker,
                         std::span<FrontPool> pools, LevelProgress& progress) {
  FrontPool& pool = pools[static_cast<std::size_t>(worker)];
  const std::span<FrontEntry> room = pool.room();
  if (!frame.fitted || frame.with_plane()) {
    const Expansion made = expand(frame, run, room);
    add_to_sums(frame, room.first(made.hits), progress.sums);
    progress.nearly = progress.nearly || made.nearly;
    append(made.hits, worker, pools, progress.front);
    return made.consumed;
  }
  EntryBuffer<kSampledRun> nearest_buffer;
  const std::span<FrontEntry> nearest = nearest_buffer.entries();
  const Expansion made = expand_close(frame, run, room, progress.sampled ? nearest : std::span<FrontEntry>(), progress);
  progress.nearly = progress.nearly || made.nearly;
  if (progress.last) {
    progress.front.entries += made.hits;
  } else {
    append(made.hits, worker, pools, progress.front);
  }
  if (made.nearest > 0) {
    const std::span<FrontEntry> left = pool.room();
    if (left.size() < made.nearest) return 0;
    std::copy_n(nearest.begin(), made.nearest, left.begin());
    append(made.nearest, worker, pools, progress.nearest);
  }
  return made.consumed;
}

}  // namespace

Level deepest_level(const Shape& a, const Shape& b, Level max_level) {
  const Level depth_b = b.kind == ShapeKind::Plane ? Level{0} : b.tree.depth();
  return std::min(max_level, std::max(a.tree.depth(), depth_b));
}

double coarsest_lift_m(const Shape& shape) {
  const double mean = static_cast<double>(shape.tree.protrusion_mean_m[0]);
  return mean + kNesting * (static_cast<double>(shape.tree.protrusion_max_m[0]) - mean);
}

PairContact coarsest_contact(const PlacedRoot& a, const PlacedRoot& b) {
  const SphereTree& tree_a = a.shape->tree;
  const SphereTree& tree_b = b.shape->tree;
  const double radius_a = static_cast<double>(tree_a.radius_m[0]);
  const double reach = radius_a + static_cast<double>(tree_b.radius_m[0]);
  const SphereContact touch =
      contact_of_spheres(b.center_m - a.center_m, radius_a, reach, b.mass_center_m - a.mass_center_m);
  const Vec3 point = a.center_m + touch.point_m;
  const double lift = coarsest_lift_m(*a.shape) + coarsest_lift_m(*b.shape);
  const double most = static_cast<double>(tree_a.protrusion_max_m[0]) + static_cast<double>(tree_b.protrusion_max_m[0]);
  PairContact contact = impact_contact(touch, point - a.mass_center_m, lift, most);
  contact.moment_b_m = (point - b.mass_center_m).cross(touch.normal);
  return contact;
}

PairContact coarsest_plane_contact(const PlacedRoot& a, const Vec3& normal, double height_m) {
  const SphereTree& tree = a.shape->tree;
  const double radius = static_cast<double>(tree.radius_m[0]);
  SphereContact touch;
  touch.normal = -normal;
  touch.gap_m = normal.dot(a.center_m) - height_m - radius;
  // The end of the sphere, not the middle between the surfaces: a cached contact point then lies a third of its lift
  // inside the plane and not all of it, which would press bodies of a pile into walls (docs/response.md). On the line
  // of the normal moments are the same anywhere.
  const Vec3 arm = a.center_m - a.mass_center_m + radius * touch.normal;
  PairContact contact =
      impact_contact(touch, arm, coarsest_lift_m(*a.shape), static_cast<double>(tree.protrusion_max_m[0]));
  // A body whose centre of mass is beneath the plane certainly penetrates it.
  const double center_m = normal.dot(a.mass_center_m) - height_m;
  contact.estimated_separation_m = std::min(contact.estimated_separation_m, center_m);
  contact.certain_separation_m = std::min(contact.certain_separation_m, center_m);
  return contact;
}

LevelProgress begin_level(const PairLevel& pair, const LevelContact& found, const FrontPool& pool) {
  POISE_ASSERT(pair.refinable());
  LevelProgress progress;
  progress.narrows = pair.level > 0 && found.narrowed;
  progress.reading = pair.front;
  progress.mark = pool.mark();
  progress.nearly = pair.nearly;
  return progress;
}

void sample_points(const PairFrame& frame, const PairLevel& pair, bool last, LevelProgress& progress) {
  const bool far = frame.margin_m >= kReachSkins * frame.skin_m;
  progress.sampled = frame.fitted && !frame.with_plane() && far && pair.front_entries > kSampledEntries;
  progress.last = last && progress.sampled;
}

Quantum run_quantum(const PairFrame& frame, std::span<FrontPool> pools, int worker, std::uint32_t units,
                    LevelProgress& progress) {
  if (progress.reading.none()) {
    return expand_run(frame, kRoots, worker, pools, progress) == 1 ? Quantum::Complete : Quantum::Full;
  }
  while (units > 0) {
    const FrontPool& source = pools[segment_worker(progress.reading)];
    const FrontSegment segment = source.segment(segment_index(progress.reading));
    const std::uint32_t wanted = std::min({units, segment.count - progress.offset, kSampledRun});
    const auto run = source.entries(segment).subspan(progress.offset, wanted);
    if (expand_run(frame, run, worker, pools, progress) < wanted) return Quantum::Full;
    units -= wanted;
    progress.offset += wanted;
    if (progress.offset == segment.count) {
      progress.reading = segment.next;
      progress.offset = 0;
      if (progress.reading.none()) return Quantum::Complete;
    }
  }
  return Quantum::More;
}

ManifoldPoint impact_point(const PairContact& contact, const Mat3& rotation_a) {
  ManifoldPoint manifold_point;
  const double length = contact.direction.norm();
  if (length > 0) manifold_point.normal.noalias() = rotation_a.transpose() * (contact.direction / length);
  manifold_point.point_m.noalias() = rotation_a.transpose() * contact.arm_m;
  manifold_point.gap_m = contact.estimated_separation_m;
  manifold_point.certain_separation_m = std::max(contact.estimated_separation_m, contact.certain_separation_m);
  return manifold_point;
}

void publish_level(const PairFrame& frame, const Mat3& rotation_a, const LevelProgress& progress, PairLevel& pair,
                   LevelContact& found) {
  ++pair.level;
  pair.nearly = progress.nearly;
  pair.front = progress.front.first;
  pair.front_entries = progress.front.entries;
  pair.next_units = progress.front.entries;
  const SegmentChain& points = progress.sampled ? progress.nearest : progress.front;
  pair.points = points.first;
  pair.point_entries = points.entries;
  make_contact(frame, progress.sums, rotation_a, found.contact);
  pair.apart = !found.contact.present;
  found.gaps_only = progress.sums.gaps_only && !pair.apart;
  // Certain penetration is an upper bound of the separation, so what is farther away leaves the nearest surfaces in.
  const bool narrows = frame.fitted && !pair.apart;
  found.reach_m = narrows ? narrowed_reach_m(frame, found.contact.certain_separation_m) : frame.margin_m;
  found.narrowed = found.reach_m < kNarrowed * frame.margin_m;
  found.manifold_points.count = 0;
  found.points_due = !pair.apart && found.contact.estimated_separation_m < found.reach_m;
}

PointsProgress begin_points(const PairFrame& frame, const PairLevel& pair, const LevelContact& found) {
  return {ManifoldClusters(found.reach_m, kClusterSkins * frame.skin_m), pair.points};
}

std::uint32_t points_units(std::uint32_t front_entries) { return front_entries / kPointsOfUnit + 1; }

Quantum run_points(const PairFrame& frame, std::span<const FrontPool> pools, std::uint32_t units,
                   PointsProgress& progress) {
  NodeContacts contacts;
  const auto flush = [&] {
    if (progress.in_block == 0) return;
    node_contacts(frame, progress.block, progress.in_block, contacts);
    progress.clusters.add(contacts, progress.in_block);
    progress.in_block = 0;
  };
  for (std::uint32_t left = units * kPointsOfUnit; left > 0 && !progress.reading.none();) {
    const FrontPool& pool = pools[segment_worker(progress.reading)];
    const FrontSegment& segment = pool.segment(segment_index(progress.reading));
    const std::span<const FrontEntry> entries = pool.entries(segment).subspan(progress.offset);
    const std::size_t count = std::min({progress.block.size() - progress.in_block, entries.size(), std::size_t{left}});
    std::copy_n(entries.begin(), count, progress.block.begin() + static_cast<std::ptrdiff_t>(progress.in_block));
    progress.in_block += count;
    progress.offset += static_cast<std::uint32_t>(count);
    left -= static_cast<std::uint32_t>(count);
    if (progress.in_block == progress.block.size()) flush();
    if (progress.offset == segment.count) {
      progress.reading = segment.next;
      progress.offset = 0;
    }
  }
  if (!progress.reading.none()) return Quantum::More;
  flush();
  return Quantum::Complete;
}

void publish_points(PointsProgress& progress, LevelContact& found) {
  progress.clusters.write(found.manifold_points);
  found.points_due = false;
}

void make_points(const PairFrame& frame, std::span<const FrontPool> pools, const PairLevel& pair, LevelContact& found) {
  PointsProgress progress = begin_points(frame, pair, found);
  while (run_points(frame, pools, points_units(pair.point_entries), progress) != Quantum::Complete) {
  }
  publish_points(progress, found);
}

}  // namespace poise::collision
