// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "collision/front/pair_refinement.h"
#include "frame/pair_progress.h"
#include "parallel/shared_counters.h"
#include "parallel/unset_vector.h"
#include "poise_assert.h"
#include "solver/lane_memory.h"

namespace poise::simulation {

/// A LevelContact that is kept; its manifold points lie elsewhere (FoundContacts::points_of), because most have fewer
/// than there can be.
struct FoundContact {
  collision::PairContact contact;
  double reach_m = 0;
  std::uint32_t points_begin = 0;
  std::uint8_t point_count = 0;
  std::uint8_t point_room = 0;  ///< it may come to have so many points where they are
  bool points_due = false;
  bool narrowed = false;
};

/// What refinement has found of the pairs of a frame, side by side: of most active pairs that is nothing, and these
/// have no entry. Invariant: an entry is one pair's (PairProgress::found), but for the first, which is that of all
/// pairs without one; entries keep their address until the next begin(). Which entry a pair has depends on threads and
/// is not part of any result.
class FoundContacts {
 public:
  /// Of a frame with at most `pairs` pairs. No pair has an entry.
  void begin(std::size_t pairs, std::size_t workers) {
    rooms_.assign(workers, Room{});
    work_.resize(std::max(work_.size(), workers));
    entries_taken_.reset();
    points_taken_.reset();
    // Each worker may have a part of a block left over. What no pair has got is not touched, and costs no memory.
    const std::size_t most = kFirst + pairs + workers * kBlock;
    if (most > entries_.size()) enlarge(most);
    points_ = memory_.use_anew<collision::ManifoldPoint>(kMostPlaces * pairs + workers * kPointBlock);
  }
  /// The memory of the points, for who comes after their last reader, *manifolds*. They are gone then.
  [[nodiscard]] solver::LaneMemory& reuse_points() {
    points_ = {};
    return memory_;
  }

  /// Of a pair without an entry: nothing that is near, and a reach beyond any other.
  [[nodiscard]] const FoundContact& of(const PairProgress& pair) const { return entries_[pair.found]; }
  /// Of a pair with a level beyond 0 that has not found it separated: the caller's to write.
  [[nodiscard]] FoundContact& of(const PairProgress& pair) { return entries_[pair.found]; }
  [[nodiscard]] std::span<const collision::ManifoldPoint> points_of(const FoundContact& found) const {
    return points_.subspan(found.points_begin, found.point_count);
  }
  [[nodiscard]] std::span<collision::ManifoldPoint> points_of(const FoundContact& found) {
    return points_.subspan(found.points_begin, found.point_count);
  }

  /// Where a worker may work on levels of a pair: with what the next one reads of the last.
  [[nodiscard]] collision::LevelContact& at_work(const PairProgress& pair, int worker) {
    collision::LevelContact& into = work_[static_cast<std::size_t>(worker)].found;
    if (pair.level.level > 0) read(pair, into);
    return into;
  }
  /// What the next level of a pair reads of its last one, or who makes its manifold points. Not the points: of a pair
  /// in the hand of a worker that is not waited for, the caller makes them at the same time (make_points_left).
  void read(const PairProgress& pair, collision::LevelContact& into) const {
    const FoundContact& found = of(pair);
    into.contact = found.contact;
    into.reach_m = found.reach_m;
    into.narrowed = found.narrowed;
  }

  /// Keeps what a level that has completed has found of a pair; `reach_m` is the most that a level looks for. Of one
  /// that is separated as far as that there is nothing to keep, and of one that is separated nobody asks more than how
  /// far it was looked.
  void keep(PairProgress& pair, const collision::LevelContact& found, double reach_m, int worker) {
    if (pair.level.level == 0) return;
    if (pair.found == 0) {
      if (pair.level.apart && found.reach_m >= reach_m) return;
      pair.found = next_of(rooms_[static_cast<std::size_t>(worker)]);
    }
    FoundContact& into = entries_[pair.found];
    if (pair.level.apart) {
      into.reach_m = found.reach_m;
    } else {
      write(found, worker, into);
    }
  }
  /// Keeps points that were due.
  void keep_points(const PairProgress& pair, const collision::ManifoldPoints& points, int worker) {
    FoundContact& into = entries_[pair.found];
    into.points_due = false;
    keep_points(into, points, worker);
  }
  /// Gives a pair an entry of its own, whatever was found of it.
  void put(PairProgress& pair, const collision::LevelContact& found, int worker) {
    pair.found = next_of(rooms_[static_cast<std::size_t>(worker)]);
    write(found, worker, entries_[pair.found]);
  }

 private:
  static constexpr std::uint32_t kFirst = 1;
  // Entries, and places for points, that a worker takes at once; chosen.
  static constexpr std::uint32_t kBlock = 16, kPointBlock = 64;
  // Of a pair: some that are one too few, and then as many as there can be; and what is left over of blocks, less than
  // a place in eight.
  static constexpr std::size_t kMostPlaces = (2 * collision::kMaxManifoldPoints - 1) * 8 / 7 + 1;
  static_assert(kPointBlock >= 8 * collision::kMaxManifoldPoints);
  // What a worker has taken and not given to pairs yet. Workers write into no cache line of another.
  struct alignas(64) Room {
    std::uint32_t next = 0, past = 0;
    std::uint32_t next_point = 0, past_points = 0;
  };
  struct alignas(64) Work {
    collision::LevelContact found;
  };
  void enlarge(std::size_t entries) {
    parallel::make_room_anew(entries_, entries);
    entries_.resize(entries);
    std::construct_at(&entries_.front())->reach_m = std::numeric_limits<double>::max();
  }
  std::uint32_t next_of(Room& room) {
    if (room.next == room.past) {
      room.next = kFirst + static_cast<std::uint32_t>(entries_taken_.take(kBlock));
      room.past = room.next + kBlock;
    }
    FoundContact& entry = entries_[room.next];
    entry.point_count = entry.point_room = 0;
    entry.points_due = false;
    return room.next++;
  }
  void write(const collision::LevelContact& found, int worker, FoundContact& into) {
    POISE_ASSERT(!found.gaps_only);
    into.contact = found.contact;
    into.reach_m = found.reach_m;
    into.narrowed = found.narrowed;
    into.points_due = found.points_due;
    keep_points(into, found.manifold_points, worker);
  }
  void keep_points(FoundContact& into, const collision::ManifoldPoints& points, int worker) {
    const auto count = static_cast<std::uint8_t>(points.count);
    if (count > into.point_room) {
      Room& room = rooms_[static_cast<std::size_t>(worker)];
      constexpr std::uint8_t kMost = collision::kMaxManifoldPoints;
      const std::uint8_t wanted = into.point_room == 0 ? count : kMost;
      if (room.next_point + wanted > room.past_points) {
        room.next_point = static_cast<std::uint32_t>(points_taken_.take(kPointBlock));
        room.past_points = room.next_point + kPointBlock;
      }
      into.points_begin = room.next_point;
      into.point_room = wanted;
      room.next_point += wanted;
    }
    into.point_count = count;
    std::copy_n(points.point.begin(), count, points_.begin() + into.points_begin);
  }

  parallel::UnsetVector<FoundContact> entries_;
  solver::LaneMemory memory_;
  std::span<collision::ManifoldPoint> points_;  // in it
  std::vector<Room> rooms_;                     // one a worker
  std::vector<Work> work_;                      // likewise
  parallel::Tickets entries_taken_, points_taken_;
};

}  // namespace poise::simulation
