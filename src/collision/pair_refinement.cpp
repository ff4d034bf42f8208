// SPDX-License-Identifier: MIT
#include "collision/pair_refinement.h"

#include <algorithm>

#include "poise_assert.h"

namespace poise::collision {
namespace {

constexpr FrontEntry kRoots[1] = {{0, 0}};

// Bodies that are known by their bounding spheres alone nest deeper than the mean protrusion says: by this share of the way to
// the largest. Measured: heights of settled piles of jacks at level 0 are then within 5 % of those at full depth.
constexpr double kNesting = 0.25;

// Expands up to `units` entries of one run into one segment; entries expanded, or none when there is no room.
std::uint32_t expand_run(const PairFrame& frame, std::span<const FrontEntry> run, FrontPool& pool, int worker,
                         std::span<FrontPool> pools, LevelProgress& progress) {
  const std::span<FrontEntry> room = pool.room();
  const Expansion made = expand(frame, run, room);
  if (made.hits == 0) return made.consumed;
  add_to_sums(frame, room.first(made.hits), progress.sums);
  const SegmentRef ref = segment_ref(worker, pool.keep(made.hits));
  if (progress.last.none()) {
    progress.first = ref;
  } else {
    pools[segment_worker(progress.last)].segment(segment_index(progress.last)).next = ref;
  }
  progress.last = ref;
  progress.entries += made.hits;
  return made.consumed;
}

}  // namespace

Level deepest_level(const Shape& a, const Shape& b, Level max_level) {
  const Level depth_b = b.kind == ShapeKind::Plane ? Level{0} : b.tree.depth();
  return std::min(max_level, std::max(a.tree.depth(), depth_b));
}

PairContact coarsest_contact(const PairFrame& frame, const Mat3& rotation_a) {
  ContactSums sums;
  add_to_sums(frame, kRoots, sums);
  sums.likely_m += kNesting * (sums.surely_m - sums.likely_m);
  return finish_contact(frame, sums, rotation_a);
}

LevelProgress begin_level(const PairLevel& pair, const FrontPool& pool) {
  POISE_ASSERT(pair.refinable());
  LevelProgress progress;
  progress.reading = pair.front;
  progress.mark = pool.mark();
  return progress;
}

Quantum run_quantum(const PairFrame& frame, std::span<FrontPool> pools, int worker, std::uint32_t units,
                    LevelProgress& progress) {
  FrontPool& pool = pools[static_cast<std::size_t>(worker)];
  if (progress.reading.none()) {
    return expand_run(frame, kRoots, pool, worker, pools, progress) == 1 ? Quantum::Complete : Quantum::Full;
  }
  while (units > 0) {
    const FrontPool& source = pools[segment_worker(progress.reading)];
    const FrontSegment segment = source.segment(segment_index(progress.reading));
    const std::uint32_t wanted = std::min(units, segment.count - progress.offset);
    const auto run = source.entries(segment).subspan(progress.offset, wanted);
    if (expand_run(frame, run, pool, worker, pools, progress) < wanted) return Quantum::Full;
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

void publish_level(const PairFrame& frame, const Mat3& rotation_a, const LevelProgress& progress, PairLevel& pair) {
  ++pair.level;
  pair.front = progress.first;
  pair.front_entries = progress.entries;
  pair.contact = finish_contact(frame, progress.sums, rotation_a);
  pair.apart = !pair.contact.present;
}

}  // namespace poise::collision
