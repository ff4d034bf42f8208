// SPDX-License-Identifier: MIT
#include "frame/publish.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "frame/contact_points.h"
#include "parallel/prefetch.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kPairGrain = 512;
constexpr std::size_t kNearGrain = 4;
// Bodies of pairs, and what was found of them, lie anywhere in memory: prefetched some pairs ahead.
constexpr std::size_t kMotionsAhead = 8;

// Prefetches what fill_cached_after() reads of a pair beside the tables.
HWY_INLINE void prefetch_motions_of(const PublishInput& input, std::uint32_t a, std::uint32_t b) {
  parallel::prefetch(input.motions.of_slot[a]);
  parallel::prefetch(input.motions.of_slot[b]);
}
HWY_INLINE void prefetch_of_pair(const PublishInput& input, std::size_t i) {
  const ActivePair& pair = input.table.pairs[i];
  parallel::prefetch(*pair.cached);
  prefetch_motions_of(input, pair.a, pair.b);
  const PairProgress& progress = input.levels.progress[i];
  if (progress.found != 0) hwy::Prefetch(&input.levels.found.of(progress).reach_m);
}

// By how much the separation of two bodies may have changed in this step.
double moved_against_m(const PublishInput& input, std::uint32_t slot_a, std::uint32_t slot_b) {
  const StepMotion& a = input.motions.of_slot[slot_a];
  const StepMotion& b = input.motions.of_slot[slot_b];
  return (b.moved_m - a.moved_m).norm() + a.turned_m + b.turned_m;
}

// What a pair takes to the next frame, the motion of this step counted. Made in its place.
void fill_cached_after(const PublishInput& input, std::size_t i, CachedPair& cached) {
  const ActivePair& pair = input.table.pairs[i];
  const PairProgress& progress = input.levels.progress[i];
  const PairPoints& points = input.manifolds.points[i];
  cached = *pair.cached;
  cached.low = pair.low();
  cached.high = pair.high();
  cached.frames_waited = progress.level.level > 0 || !progress.refinable() ? 0 : cached.frames_waited + 1;
  cached.seen = progress.seen;
  cached.band = progress.band;
  cached.frames_touched = input.levels.learns ? frames_touched(pair) : std::uint8_t{0};
  if (!progress.held) cached.touching = false;
  cached.slot = points.point_count > 0 ? points.slot : kNoSlot;
  cached.solved = points.solved;
  cached.point_count = points.point_count;
  cached.nearest_m = points.nearest_m;
  cached.impact_gap_m = points.impact_gap_m;
  cached.looked_m = points.looked_m;
  if (progress.fresh()) {
    cached.level = progress.level.level;
    cached.apart = progress.level.apart;
    cached.reach_m = std::min(pair.reach_m, input.levels.found.of(progress).reach_m);
    if (progress.level.apart && progress.level.front_entries == 0 && !progress.level.nearly && !progress.exact)
      cached.reach_m += wide_m(pair);
    cached.moved_m = 0;
  } else if (progress.cached == CacheUse::None && !progress.held) {
    // The one point of level 0 is cached like others; that nothing was solved there is no knowledge.
    const bool holds = points.point_count > 0 && !progress.exact && pair.reach_m > pair.margin_m;
    cached.level = 0;
    cached.apart = false;
    cached.reach_m = holds ? pair.reach_m : 0;
    cached.moved_m = 0;
  }
  cached.moved_m += moved_against_m(input, pair.a, pair.b);
}

// The same of a pair that is apart.
void fill_apart_after(const PublishInput& input, const CachedPair& before, CachedPair& cached) {
  cached = before;
  cached.frames_waited = 0;
  cached.frames_touched = 0;
  cached.moved_m += moved_against_m(input, before.low, before.high);
}

// Does the pair of a manifold touch? Impulses make a touch of what is separated.
bool touches(const PublishInput& input, const PointCache& points, std::size_t m) {
  if (!input.velocities.applied_impulse_ns[m].isZero(0)) return true;
  if (!input.velocities.impact_ns.empty() && !input.velocities.impact_ns[m].isZero(0)) return true;
  const std::uint32_t index = input.manifolds.manifolds[m].pair;
  const PairPoints& made = input.manifolds.points[index];
  const CachedPair& cached = *input.table.pairs[index].cached;
  // The gap that *manifolds* has computed says it, but where the bodies have moved since by more, or rounding decides.
  constexpr double kRoundingOfSkin = 1e-6;
  const bool cached_gap = input.levels.progress[index].from_cache();
  const double changed_m =
      (cached_gap ? 2.0 * (cached.moved_m - made.looked_m) : 0.0) + kRoundingOfSkin * input.table.pairs[index].skin_m;
  const bool of_spheres = input.contact == ContactModel::Paper && !cached_gap;
  if (!of_spheres && std::abs(made.impact_gap_m) > changed_m) return made.impact_gap_m <= 0;
  return solved_gap_m(input.solved_pair(points), index) <= 0;
}

// What the body in the lower slot gave the other in the step, by contact and impacts of a manifold.
Vec3 touch_impulse_ns(const PublishInput& input, std::size_t m) {
  const ActivePair& pair = input.table.pairs[input.manifolds.manifolds[m].pair];
  const Vec3 impulse_ns = input.velocities.impulse_ns(m);
  return pair.a == pair.low() ? impulse_ns : Vec3(-impulse_ns);
}

// What the solved pair of a manifold tells the caller. The plane of a pair stands second in the row, whatever its slot.
Contact contact_at(const PublishInput& input, const PointCache& points, std::size_t m) {
  const std::uint32_t index = input.manifolds.manifolds[m].pair;
  const ActivePair& pair = input.table.pairs[index];
  const double sign = pair.a == pair.low() ? 1.0 : -1.0;
  Contact contact = contact_outline(input, points, m);
  contact.gap_m = solved_gap_m(input.solved_pair(points), index);
  contact.impulse_ns = sign * input.velocities.impulse_ns(m);
  list_points({input.motion, points, pair, input.manifolds.points[index], input.table.terms.dt_s}, sign, contact);
  return contact;
}

// The bodies that were removed since the step.
class Removed {
 public:
  explicit Removed(std::span<const BodyId> bodies) {
    for (const BodyId& body : bodies) slots_.push_back(body.slot);
    std::sort(slots_.begin(), slots_.end());
  }
  // Is one of them in the pair?
  [[nodiscard]] bool in(const ActivePair& pair) const { return has(pair.a) || has(pair.b); }

 private:
  [[nodiscard]] bool has(std::uint32_t slot) const { return std::binary_search(slots_.begin(), slots_.end(), slot); }

  std::vector<std::uint32_t> slots_;
};

// Pairs that met within the step, put in among the others.
void add_swept_contacts(const PublishInput& input, const Removed& removed, std::vector<Contact>& contacts) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  if (input.velocities.swept.hits.empty()) return;
  for (const SweptHit& hit : input.velocities.swept.hits) {
    const ActivePair& pair = input.table.pairs[hit.pair];
    if (removed.in(pair)) continue;
    const double sign = pair.a == pair.low() ? 1.0 : -1.0;
    Contact contact;
    contact.a = bodies.id_of(pair.low());
    contact.b = bodies.id_of(pair.high());
    contact.level = collision::deepest_level(*bodies.shape[pair.a], *bodies.shape[pair.b], kMaxTreeDepth);
    contact.normal = sign * hit.normal;
    contact.point_m = hit.point_m;
    contact.gap_m = hit.gap_m;
    contact.impulse_ns = sign * hit.impulse_ns;
    contact.point_slots[0] = {contact.point_m, contact.normal, contact.gap_m, contact.impulse_ns};
    contact.point_count = 1;
    contacts.push_back(contact);
  }
  std::stable_sort(contacts.begin(), contacts.end(), [](const Contact& x, const Contact& y) {
    return std::pair(x.a.slot, x.b.slot) < std::pair(y.a.slot, y.b.slot);
  });
  if (contacts.empty()) return;
  // A pair that touched at the start too is one contact.
  std::size_t cached = 0;
  for (std::size_t k = 1; k < contacts.size(); ++k) {
    if (contacts[k].a == contacts[cached].a && contacts[k].b == contacts[cached].b) {
      contacts[cached].impulse_ns += contacts[k].impulse_ns;
      merge_points(contacts[k], contacts[cached]);
    } else {
      contacts[++cached] = contacts[k];
    }
  }
  contacts.resize(cached + 1);
}

bool precedes(const ContactEvent& x, const ContactEvent& y) {
  return std::tuple(x.a.slot, x.b.slot, x.a.generation, x.b.generation) <
         std::tuple(y.a.slot, y.b.slot, y.a.generation, y.b.generation);
}

// Slots of pairs that have lost their points, in canonical order.
void release_unused(const PublishInput& input, PointCache& points, Publication& publication,
                    parallel::Executor& executor) {
  if (input.manifolds.unused_slots == 0) return;
  const PairTable& table = input.table;
  const std::vector<SolvedCount>& of_chunk = input.manifolds.solved_of_chunk;
  std::size_t position = points.released.size();
  points.released.resize(position + input.manifolds.unused_slots);
  publication.counts.reserve(table.known_of_chunk.capacity());
  publication.counts.clear();
  for (const SolvedCount& count : of_chunk)
    publication.counts.push_back(std::exchange(position, position + count.unused_slots));
  parallel::parallel_for(executor, of_chunk.size(), 1, [&](std::size_t chunk, std::size_t, int) {
    if (of_chunk[chunk].unused_slots == 0) return;
    std::size_t at = publication.counts[chunk];
    for (std::size_t i = table.begin_of(chunk); i < table.end_of(chunk); ++i) {
      const PairPoints& made = input.manifolds.points[i];
      if (made.point_count == 0 && made.slot != kNoSlot) points.released[at++] = made.slot;
    }
  });
}

// Contacts end of cached pairs that are no longer active, and their slots are released.
void end_inactive(const PublishInput& input, ContactCache& cache, Publication& publication,
                  parallel::Executor& executor) {
  const parallel::UnsetVector<std::uint8_t>& active = input.table.still_near;
  std::vector<std::uint32_t>& released = cache.points.released;
  const std::size_t released_before = released.size();
  parallel::select(
      executor, active.size(), kPairGrain, publication.counts,
      [&](std::size_t i) { return active[i] == 0 && cache.pairs[i].slot != kNoSlot; },
      [&](std::size_t count) { released.resize(released_before + count); },
      [&](std::size_t i, std::size_t position) { released[released_before + position] = cache.pairs[i].slot; });
  parallel::UnsetVector<ContactEvent>& events = publication.of_inactive;
  parallel::select(
      executor, active.size(), kPairGrain, publication.counts,
      [&](std::size_t i) { return active[i] == 0 && cache.pairs[i].touching; },
      [&](std::size_t count) { events.resize(count); },
      [&](std::size_t i, std::size_t position) {
        const CachedPair& pair = cache.pairs[i];
        events[position] = {ContactEvent::Kind::End, input.scene.bodies.id_of(pair.low),
                            input.scene.bodies.id_of(pair.high)};
      });
}

// Events of the pairs of this step.
void list_active(const PublishInput& input, const CachedPairList& pairs, Publication& publication,
                 parallel::Executor& executor) {
  const parallel::UnsetVector<std::uint8_t>& changed = publication.touch_changed;
  parallel::UnsetVector<ContactEvent>& events = publication.of_active;
  parallel::select(
      executor, changed.size(), kPairGrain, publication.counts,
      [&](std::size_t i) { return changed[i] != 0 || (input.persist_events && pairs[publication.place[i]].touching); },
      [&](std::size_t count) { events.resize(count); },
      [&](std::size_t i, std::size_t position) {
        const CachedPair& pair = pairs[publication.place[i]];
        ContactEvent event;
        if (changed[i] == 0) {
          event.kind = ContactEvent::Kind::Persist;
        } else {
          event.kind = pair.touching ? ContactEvent::Kind::Begin : ContactEvent::Kind::End;
        }
        event.a = input.scene.bodies.id_of(pair.low);
        event.b = input.scene.bodies.id_of(pair.high);
        if (pair.touching) event.impulse_ns = publication.touch_ns[i];
        events[position] = event;
      });
}

// Contacts that began or ended since the last frame, in canonical order. A pair has one event at most; of two in the
// same slots, the bodies that were removed come first.
void make_events(const PublishInput& input, Publication& publication, const ContactCache& cache,
                 ContactEvents& published, parallel::Executor& executor) {
  list_active(input, cache.pairs, publication, executor);
  parallel::UnsetVector<ContactEvent>& inactive = publication.of_inactive;
  std::vector<ContactEvent>& of_removed = published.of_removed;
  if (!of_removed.empty()) {
    // Few: as many as the caller's removals ended.
    inactive.insert(inactive.end(), of_removed.begin(), of_removed.end());
    std::sort(inactive.begin(), inactive.end(), precedes);
    of_removed.clear();
  }
  std::vector<ContactEvent>& events = published.events;
  events.resize(publication.of_active.size() + inactive.size());
  parallel::merge(executor, kPairGrain, publication.of_active, inactive, precedes,
                  [&](const ContactEvent& event, std::size_t position) { events[position] = event; });
}

// Near pairs of a chunk after the step.
void fill_chunk_after(const PublishInput& input, std::size_t chunk, CachedPairList& next, Publication& publication) {
  const PairTable& table = input.table;
  const bool distant = table.near_count() > parallel::kPairsAtHand;
  const std::size_t begin = table.begin_of(chunk);
  const std::size_t end = table.end_of(chunk);
  const std::size_t before = table.near_begin(chunk);
  for (std::size_t i = begin; i < end; ++i) {
    if (distant && i + kMotionsAhead < end) prefetch_of_pair(input, i + kMotionsAhead);
    const std::size_t place = before + table.near_active(chunk, i - begin).place;
    publication.place[i] = static_cast<std::uint32_t>(place);
    fill_cached_after(input, i, next[place]);
    // What waits goes on touching as it did.
    const bool held = input.levels.progress[i].held;
    publication.touch_changed[i] = table.pairs[i].cached->touching && !held ? 1 : 0;
    if (held) publication.touch_ns[i].setZero();
  }
  const std::size_t apart = table.apart_count(chunk);
  for (std::size_t k = 0; k < apart; ++k) {
    if (distant && k + kMotionsAhead < apart) {
      const CachedPair& ahead = table.apart(chunk, k + kMotionsAhead);
      prefetch_motions_of(input, ahead.low, ahead.high);
    }
    fill_apart_after(input, table.apart(chunk, k), next[before + table.near_apart(chunk, k).place]);
  }
}

}  // namespace

void publish(const PublishInput& input, ContactCache& cache, ContactEvents& events, Publication& publication,
             parallel::Executor& executor) {
  const PairTable& table = input.table;
  // A later frame must find the memory that this one needed.
  for (auto* list : {&publication.of_active, &publication.of_inactive})
    parallel::reserve_anew(*list, 2 * table.capacity());
  events.events.reserve(publication.of_active.capacity());
  end_inactive(input, cache, publication, executor);
  release_unused(input, cache.points, publication, executor);
  // What the step began with stays as it is.
  std::swap(cache.pairs, cache.previous_pairs);
  CachedPairList& next = cache.pairs;
  parallel::reserve_anew(next, table.capacity());
  parallel::make_room_anew(next, table.near_count());
  next.resize(table.near_count());
  parallel::UnsetVector<std::uint8_t>& touch_changed = publication.touch_changed;
  touch_changed.resize(table.size());
  parallel::reserve_anew(publication.touch_ns, table.capacity());
  publication.touch_ns.resize(table.size());
  parallel::reserve_anew(publication.place, table.capacity());
  publication.place.resize(table.size());
  parallel::parallel_for(executor, table.chunks(), kNearGrain, [&](std::size_t first, std::size_t past, int) {
    for (std::size_t chunk = first; chunk < past; ++chunk) fill_chunk_after(input, chunk, next, publication);
  });
  const Manifolds& manifolds = input.manifolds;
  parallel::parallel_for(executor, manifolds.manifolds.size(), kPairGrain,
                         [&](std::size_t begin, std::size_t end, int) {
                           for (std::size_t m = begin; m < end; ++m) {
                             if (!touches(input, cache.points, m)) continue;
                             const std::uint32_t i = manifolds.manifolds[m].pair;
                             next[publication.place[i]].touching = true;
                             touch_changed[i] ^= 1U;
                             if (touch_changed[i] != 0 || input.persist_events)
                               publication.touch_ns[i] = touch_impulse_ns(input, m);
                           }
                         });
  for (const SweptHit& hit : input.velocities.swept.hits) {
    bool& touching = next[publication.place[hit.pair]].touching;
    const ActivePair& pair = table.pairs[hit.pair];
    if (!touching) {
      touch_changed[hit.pair] ^= 1U;
      publication.touch_ns[hit.pair].setZero();
    }
    publication.touch_ns[hit.pair] += (pair.a == pair.low() ? 1.0 : -1.0) * hit.impulse_ns;
    touching = true;
  }
  make_events(input, publication, cache, events, executor);
}

Contact contact_outline(const PublishInput& input, const PointCache& points, std::size_t m) {
  const std::uint32_t index = input.manifolds.manifolds[m].pair;
  const ActivePair& pair = input.table.pairs[index];
  const double sign = pair.a == pair.low() ? 1.0 : -1.0;
  Contact contact;
  contact.a = input.scene.bodies.id_of(pair.low());
  contact.b = input.scene.bodies.id_of(pair.high());
  contact.level = input.levels.progress[index].solved_level();
  const solver::PlacedPoint point = impact_point_of(input.motion, points, pair, input.manifolds.points[index].slot);
  contact.normal = sign * point.normal;
  contact.point_m = input.motion.poses[pair.a].position_m + point.arm_m;
  return contact;
}

std::vector<Contact> list_contacts(const PublishInput& input, const PointCache& points,
                                   std::span<const BodyId> removed_bodies, ContactListing listing) {
  const Removed removed(removed_bodies);
  const Manifolds& manifolds = input.manifolds;
  std::vector<Contact> contacts;
  for (std::size_t m = 0; m < manifolds.manifolds.size(); ++m) {
    // Asked first: of a body that was removed there is no shape any more.
    if (removed.in(input.table.pairs[manifolds.manifolds[m].pair])) continue;
    if (listing != ContactListing::Solved && !touches(input, points, m)) continue;
    contacts.push_back(contact_at(input, points, m));
  }
  add_swept_contacts(input, removed, contacts);
  return contacts;
}

}  // namespace poise::simulation
