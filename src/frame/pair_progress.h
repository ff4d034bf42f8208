// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "collision/front/pair_refinement.h"
#include "poise/decisions.h"
#include "poise/types.h"

namespace poise::simulation {

/// What of a cached pair counts in this frame.
enum class CacheUse : std::uint8_t {
  None,       ///< nothing: the pair begins at level 0
  Separated,  ///< it cannot touch in this step
  Points,     ///< it can touch at its cached points only
  Expired,    ///< its cached points are too old to be sure of, and better than level 0
  Parted,     ///< likewise that it is separated
};

/// Where a pair's contact of this frame comes from.
enum class ContactState : std::uint8_t {
  Coarsest,         ///< level 0: its two root spheres
  Cached,           ///< the contact points of an earlier frame
  Refined,          ///< the deepest level that this frame completed
  Exact,            ///< made by backtracking: never refined
  CachedSeparated,  ///< no contact: an earlier frame found it separated, for sure or not
  Separated,        ///< no contact: this frame found it separated
};

/// What stopped a pair that has levels left, if not that the budget was used up or its front was full.
enum class Stop : std::uint8_t {
  None,
  Reused,  ///< before its first level: the frame did not fit, and what is cached is used once more
  Cut,     ///< its next level was begun and discarded
  Unseen,  ///< the policy leaves it out
};

/// What *coarse* knows of a pair before its refinement begins. One a pair of a frame: small.
struct PairStart {
  std::uint32_t next_units = 1;      ///< as PairLevel::next_units, of the two roots
  Level deepest = 0;                 ///< likewise
  bool polygons = false;             ///< likewise
  CacheUse cached = CacheUse::None;  ///< these as of PairProgress
  Level cached_level = 0;
  std::uint8_t seen = 0, band = 0, waited = 0;
  bool on_ball = false;  ///< as of PairProgress

  [[nodiscard]] bool refinable() const {
    return deepest > 0 && cached != CacheUse::Separated && !(cached == CacheUse::Points && cached_level >= deepest);
  }
};
static_assert(sizeof(PairStart) == 12);

/// How far a pair has come in this frame. Small: the budget goes through all pairs, and most of them need no more.
///
/// Active pairs have one. A pair that is apart (coarse.h) would be CachedSeparated from *coarse* to the end.
///
/// Transitions, in the order of stages. A pair has one state at a time; what is not listed does not happen.
///
///   stage   from             event                                                to
///   coarse  -                nothing cached, or not sure enough                    Coarsest
///   coarse  -                cached as separated, for sure                         CachedSeparated
///   coarse  -                cached as separated, not sure any more (Parted)       CachedSeparated
///   coarse  -                cached points, for sure (Points) or not (Expired)     Cached
///   coarse  Coarsest         a fast body, surfaces touch (backtracking)            Exact
///   coarse  Coarsest         a fast body, surfaces apart (backtracking)            Separated
///   refine  Coarsest         the frame does not fit: reused as separated (Parted)  CachedSeparated
///   refine  Coarsest         the frame does not fit: reused with its points        Cached
///   refine  Coarsest         a level completes, nodes are near                     Refined
///   refine  Cached           a level at least as deep as the cached one completes  Refined
///   refine  Cached           a shallower level completes, nodes are near           Cached (still; refinement goes on)
///   refine  CachedSeparated  (Parted) likewise, at least as deep or shallower      Refined, or CachedSeparated still
///   refine  Refined          a deeper level completes, nodes are near              Refined
///   refine  any that is refined          a level completes, no nodes are near      Separated
///
/// `held` is decided before the first level and changes none of these.
/// `full` (its front did not fit into the pool) stops refinement and changes no state. After refine no state changes.
struct PairProgress {
  collision::PairLevel level;  ///< what refinement has completed in this frame
  std::uint32_t found = 0;     ///< of FoundContacts; 0: nothing was found, or nothing that is near
  CacheUse cached = CacheUse::None;
  bool full = false;         ///< its front did not fit into the pool: the pair stays at its level
  bool exact : 1 = false;    ///< its contact counts whatever its level: a pair of backtracking
  bool on_ball : 1 = false;  ///< a is a ball and b is not: where a is touched does not turn with it
  bool held = false;         ///< its bodies wait: it is refined, but has no response in this frame
  Level cached_level = 0;    ///< that found out what is cached
  std::uint8_t seen = 0;     ///< as CachedPair::seen, of this frame if the pair was ranked in it
  std::uint8_t band = 0;     ///< as CachedPair::band, likewise
  std::uint8_t waited = 0;   ///< as CachedPair::frames_waited, at most 255
  bool ranked = false;       ///< in this frame
  bool points_due = false;   ///< under a deadline: if it comes no further, its contact points are to be made in the end
  /// Band of the score that its next level waits with, or its last one had; 0: none was found.
  std::uint8_t turn = 0;
  Stop stop = Stop::None;

  PairProgress() = default;
  explicit PairProgress(const PairStart& start) { begin(start); }
  /// Of one that has not begun.
  void begin(const PairStart& start) {
    level.deepest = start.deepest;
    level.polygons = start.polygons;
    level.next_units = start.next_units;
    cached = start.cached;
    cached_level = start.cached_level;
    seen = start.seen;
    band = start.band;
    waited = start.waited;
    on_ball = start.on_ball;
  }

  void stop_for_time() {
    if (stop != Stop::Reused || level.level > 0) stop = Stop::Cut;
  }

  [[nodiscard]] ContactState state() const {
    if (level.apart) return ContactState::Separated;
    if (apart()) return ContactState::CachedSeparated;
    if (exact) return ContactState::Exact;
    if (from_cache()) return ContactState::Cached;
    return level.level > 0 ? ContactState::Refined : ContactState::Coarsest;
  }
  [[nodiscard]] bool has_cached_points() const { return cached == CacheUse::Points || cached == CacheUse::Expired; }
  /// Refinement found out more than what is cached.
  [[nodiscard]] bool fresh() const {
    const bool knows = has_cached_points() || cached == CacheUse::Parted;
    return level.level > 0 && (!knows || level.apart || level.level >= cached_level);
  }
  [[nodiscard]] bool from_cache() const { return has_cached_points() && !fresh(); }
  [[nodiscard]] bool apart() const {
    return level.apart || cached == CacheUse::Separated || (cached == CacheUse::Parted && !fresh());
  }
  [[nodiscard]] Level solved_level() const { return from_cache() ? cached_level : level.level; }
  [[nodiscard]] bool by_polygons() const { return level.polygons && solved_level() == level.deepest; }
  [[nodiscard]] bool refinable() const {
    return level.refinable() && cached != CacheUse::Separated &&
           !(cached == CacheUse::Points && cached_level >= level.deepest);
  }
};
static_assert(sizeof(PairProgress) == 44);

/// What became of a pair, once refinement has ended.
PairOutcome outcome_of(const PairProgress& progress);

}  // namespace poise::simulation
