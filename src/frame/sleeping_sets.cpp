// SPDX-License-Identifier: MIT
#include "frame/sleeping_sets.h"

#include <algorithm>
#include <span>
#include <utility>

#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kSetGrain = 1024;
// What a set has room for from the beginning: a few bodies, and a share of all.
constexpr std::size_t kLeastOfSet = 256, kShareOfSet = 4;

bool sleeps(const SleepAccess& access, std::uint32_t slot) { return access.bodies.asleep[slot] != 0; }
bool sleeps(const SleepAccess& access, const CachedPair& pair) {
  return sleeps(access, pair.low) || sleeps(access, pair.high);
}

bool before(const CachedPair& x, const CachedPair& y) { return std::pair(x.low, x.high) < std::pair(y.low, y.high); }

// Takes the pairs that keep(pair) is false of out of a list, in order.
template <class Keep>
void split(SleepingState& sleep, CachedPairList& list, Keep&& keep, CachedPairList& out, parallel::Executor& executor) {
  const auto move = [&](bool kept, CachedPairList& into) {
    parallel::select(
        executor, list.size(), kSetGrain, sleep.counts, [&](std::size_t i) { return keep(list[i]) == kept; },
        [&](std::size_t count) { into.resize(count); },
        [&](std::size_t i, std::size_t position) { into[position] = list[i]; });
  };
  move(false, out);
  if (out.empty()) return;
  move(true, sleep.merged);
  std::swap(list, sleep.merged);
}

// Adds sorted pairs to a sorted list.
void join(SleepingState& sleep, std::span<const CachedPair> from, CachedPairList& list, parallel::Executor& executor) {
  if (from.empty()) return;
  sleep.merged.resize(from.size() + list.size());
  parallel::merge(executor, kSetGrain, from, std::span<const CachedPair>(list), before,
                  [&](const CachedPair& pair, std::size_t position) { sleep.merged[position] = pair; });
  std::swap(list, sleep.merged);
}

// What one body's own part of waking is beside that of the BodyStore; `waited`: it was paused.
void note_woken(const SleepAccess& access, std::uint32_t slot, bool waited) {
  if (waited) {
    // It has waited long enough, or is wanted.
    access.bodies.frames_held[slot] = kMostFramesHeld;
  } else {
    access.sleeping.still_s[slot] = 0;
  }
}

// Wakes the bodies of sleep.slots that still sleep.
void wake_bodies(const SleepAccess& access, parallel::Executor& executor) {
  const SleepingState& sleep = access.sleeping;
  parallel::Tickets woken;
  parallel::Tickets paused;
  parallel::parallel_for(executor, sleep.slots.size(), kSetGrain, [&](std::size_t begin, std::size_t end, int) {
    std::size_t own_woken = 0;
    std::size_t own_paused = 0;
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t slot = sleep.slots[k];
      if (access.bodies.asleep[slot] == 0) continue;
      const bool waited = access.bodies.begin_wake(slot);
      note_woken(access, slot, waited);
      ++own_woken;
      own_paused += waited ? 1 : 0;
    }
    woken.take(own_woken);
    paused.take(own_paused);
  });
  const std::size_t all = woken.take(0);
  const std::size_t waited = paused.take(0);
  access.bodies.count_woken(all, waited);
  access.sleeping.woken += all - waited;
}

// The islands of a set that are to wake.
void wake_requested_of(const SleepAccess& access, SleepingSet& set, parallel::Executor& executor) {
  SleepingState& sleep = access.sleeping;
  const auto wakes = [&](std::uint32_t slot) { return sleep.wake_requested[sleep.island[slot]] != 0; };
  const auto list = [&](bool that_wake) {
    parallel::select(
        executor, set.slots.size(), kSetGrain, sleep.counts,
        [&](std::size_t k) { return wakes(set.slots[k]) == that_wake; },
        [&](std::size_t count) { sleep.slots.resize(count); },
        [&](std::size_t k, std::size_t position) { sleep.slots[position] = set.slots[k]; });
  };
  list(true);
  if (sleep.slots.empty()) return;
  wake_bodies(access, executor);
  if (sleep.slots.size() == set.slots.size()) {
    set.slots.clear();
    join(sleep, set.pairs, access.cache.pairs, executor);
    set.pairs.clear();
    return;
  }
  list(false);
  set.slots.assign(sleep.slots.begin(), sleep.slots.end());
  split(
      sleep, set.pairs, [&](const CachedPair& pair) { return sleeps(access, pair); }, sleep.taken, executor);
  join(sleep, sleep.taken, access.cache.pairs, executor);
}

}  // namespace

void reserve_sets(const SleepAccess& access, parallel::Executor& executor) {
  reserve_slots(access);
  SleepingState& sleep = access.sleeping;
  const std::size_t slots = access.bodies.slot_count();
  const std::size_t pairs = access.cache.pairs.capacity();
  for (CachedPairList* list : {&sleep.merged, &sleep.taken}) parallel::reserve_anew(*list, pairs);
  sleep.parent.reserve(slots);
  sleep.restless.reserve(slots);
  sleep.slots.reserve(slots);
  sleep.islands_paused.reserve(slots);
  sleep.islands_sorting.reserve(slots);
  // One for each step that something may wait for, and what sleeps. Memory that is not used costs nothing.
  constexpr std::size_t kSets = 2 * (std::size_t{kMostStepsUnseen} + 1);
  sleep.sets.reserve(kSets);
  while (sleep.sets.size() < std::size_t{kMostStepsUnseen} + 1) sleep.sets.emplace_back();
  for (SleepingSet& set : sleep.sets) {
    set.slots.reserve(std::min(slots, kLeastOfSet + slots / kShareOfSet));
    parallel::reserve(executor, set.pairs, std::min(pairs, kLeastOfSet + pairs / kShareOfSet));
    set.unseen.reserve(std::min(slots, kLeastOfSet + slots / kShareOfSet));
  }
}

void reserve_slots(const SleepAccess& access) {
  const std::size_t slots = access.bodies.slot_count();
  if (access.sleeping.still_s.size() >= slots) return;
  access.sleeping.still_s.resize(slots, 0.0);
  access.sleeping.island.resize(slots, 0);
  access.sleeping.set_of.resize(slots, 0);
  access.sleeping.wake_requested.resize(slots, 0);
}

std::uint32_t set_that_wakes(SleepingState& sleep, std::uint64_t wakes) {
  const auto fits = [&](const SleepingSet& set) {
    return wakes != SleepingSet::kNever && !set.slots.empty() && set.wakes == wakes;
  };
  const auto is_free = [](const SleepingSet& set) { return set.slots.empty() && set.pairs.empty(); };
  auto at = std::find_if(sleep.sets.begin(), sleep.sets.end(), fits);
  if (at == sleep.sets.end()) at = std::find_if(sleep.sets.begin(), sleep.sets.end(), is_free);
  const auto index = static_cast<std::uint32_t>(at - sleep.sets.begin());
  if (index == sleep.sets.size()) sleep.sets.emplace_back();
  sleep.sets[index].wakes = wakes;
  return index;
}

void add_to_set(SleepingState& sleep, std::uint32_t set, std::uint32_t slot, std::uint32_t island) {
  sleep.sets[set].slots.push_back(slot);
  sleep.set_of[slot] = set;
  sleep.island[slot] = island;
}

void take_pairs_of_sleepers(const SleepAccess& access, parallel::Executor& executor) {
  SleepingState& sleep = access.sleeping;
  CachedPairList& pairs = access.cache.pairs;
  // Of each set where its pairs go: to its own list if that is empty, or else to be merged. First those that stay.
  std::vector<std::span<CachedPair>>& places = sleep.places;
  places.assign(sleep.sets.size() + 1, {});
  parallel::group(
      executor, pairs.size(), kSetGrain, places.size(), sleep.counts,
      [&](std::size_t i) -> std::size_t {
        const std::uint32_t low = pairs[i].low;
        if (sleeps(access, low)) return std::size_t{sleep.set_of[low]} + 1;
        const std::uint32_t high = pairs[i].high;
        return sleeps(access, high) ? std::size_t{sleep.set_of[high]} + 1 : 0;
      },
      [&](std::span<const std::size_t> sizes) {
        sleep.taken.resize(pairs.size());
        std::size_t taken = 0;
        sleep.merged.resize(sizes[0]);
        places[0] = sleep.merged;
        for (std::size_t set = 0; set < sleep.sets.size(); ++set) {
          CachedPairList& own = sleep.sets[set].pairs;
          const std::size_t size = sizes[set + 1];
          if (own.empty()) {
            own.resize(size);
            places[set + 1] = own;
          } else {
            places[set + 1] = std::span(sleep.taken).subspan(taken, size);
            taken += size;
          }
        }
      },
      [&](std::size_t i, std::size_t place, std::size_t position) { places[place][position] = pairs[i]; });
  std::swap(pairs, sleep.merged);
  for (std::size_t set = 0; set < sleep.sets.size(); ++set) {
    CachedPairList& own = sleep.sets[set].pairs;
    if (places[set + 1].data() != own.data()) join(sleep, places[set + 1], own, executor);
  }
}

void wake_body(const SleepAccess& access, std::uint32_t slot) {
  const bool waited = access.bodies.paused[slot] != 0;
  access.bodies.wake(slot);
  note_woken(access, slot, waited);
  access.sleeping.woken += waited ? 0 : 1;
}

void wake_requested_islands(const SleepAccess& access, parallel::Executor& executor) {
  SleepingState& sleep = access.sleeping;
  for (SleepingSet& set : sleep.sets) {
    if (!set.slots.empty()) wake_requested_of(access, set, executor);
  }
  std::fill(sleep.wake_requested.begin(), sleep.wake_requested.end(), std::uint8_t{0});
  sleep.any_wake_requested = false;
}

}  // namespace poise::simulation
