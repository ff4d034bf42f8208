// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "collision/front/pair_refinement.h"
#include "frame/pair_progress.h"
#include "parallel/shared_counters.h"
#include "parallel/unset_vector.h"

namespace poise::simulation {

/// What refinement has found of the pairs of a frame, side by side: of most active pairs that is nothing, and these
/// have no entry. Invariant: an entry is one pair's (PairProgress::found), but for the first, which is that of all
/// pairs without one; entries keep their address until the next begin(). Which entry a pair has depends on threads and
/// is not part of any result.
class FoundContacts {
 public:
  /// Of a frame with at most `pairs` pairs. No pair has an entry.
  void begin(std::size_t pairs, std::size_t workers) {
    rooms_.assign(workers, Room{});
    blocks_.reset();
    // Each worker may have a part of a block left over. What no pair has got is not touched, and costs no memory.
    const std::size_t most = kFirst + pairs + workers * kBlock;
    if (most > entries_.size()) enlarge(most);
  }

  /// Of a pair without an entry: nothing that is near, and a reach beyond any other.
  [[nodiscard]] const collision::LevelContact& of(const PairProgress& pair) const { return entries_[pair.found]; }
  /// Of a pair with a level beyond 0 that has not found it separated: the caller's to write.
  [[nodiscard]] collision::LevelContact& of(const PairProgress& pair) { return entries_[pair.found]; }

  /// Where the next level of a pair writes what it finds: the entry of the pair, or one that it gets by keep().
  [[nodiscard]] collision::LevelContact& open(const PairProgress& pair, int worker) {
    return entries_[pair.found != 0 ? pair.found : next_of(rooms_[static_cast<std::size_t>(worker)])];
  }
  /// Gives a pair the entry of open(), once a level has completed; `reach_m` is the most that a level looks for. Of one
  /// that is separated as far as that there is nothing to keep.
  void keep(PairProgress& pair, double reach_m, int worker) {
    if (pair.found != 0 || pair.level.level == 0) return;
    Room& room = rooms_[static_cast<std::size_t>(worker)];
    if (is_kept(pair.level, entries_[room.next].reach_m, reach_m)) pair.found = room.next++;
  }
  /// Would keep() give a pair an entry? `found_m`: how far the level has looked.
  [[nodiscard]] static bool is_kept(const collision::PairLevel& level, double found_m, double reach_m) {
    return !level.apart || found_m < reach_m;
  }
  /// Gives a pair an entry of its own, whatever was found of it.
  void put(PairProgress& pair, const collision::LevelContact& found, int worker) {
    Room& room = rooms_[static_cast<std::size_t>(worker)];
    pair.found = next_of(room);
    ++room.next;
    entries_[pair.found] = found;
  }

 private:
  static constexpr std::uint32_t kFirst = 1;
  static constexpr std::uint32_t kBlock = 16;  // entries that a worker takes at once; chosen
  // The entries that a worker has taken and not given to pairs yet. Workers write into no cache line of another.
  struct alignas(64) Room {
    std::uint32_t next = 0, past = 0;
  };
  void enlarge(std::size_t entries) {
    parallel::make_room_anew(entries_, entries);
    entries_.resize(entries);
    std::construct_at(&entries_.front())->reach_m = std::numeric_limits<double>::max();
  }
  std::uint32_t next_of(Room& room) {
    if (room.next == room.past) {
      room.next = kFirst + static_cast<std::uint32_t>(blocks_.take(kBlock));
      room.past = room.next + kBlock;
    }
    return room.next;
  }

  parallel::UnsetVector<collision::LevelContact> entries_;
  std::vector<Room> rooms_;  // one a worker
  parallel::Tickets blocks_;
};

}  // namespace poise::simulation
