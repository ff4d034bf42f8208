// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "frame/refine/refine.h"
#include "frame/view_cues.h"

/// Cues and scores of eight pairs side by side: ranking a frame's pairs one by one takes a third of a microsecond each,
/// more than there is where refinement has a millisecond for ten thousand of them.
namespace poise::simulation {

/// Pairs that are scored at once.
inline constexpr std::size_t kScoredAtOnce = 8;

/// Does a policy weigh no more than what is found side by side: by the gain of a level, the cues frustum, size,
/// eccentricity, closing, waiting, importance and touch? Those of others, and of a host, are found one by one.
[[nodiscard]] bool scores_in_lanes(const scheduler::Policy& policy);

/// What is scored of a pair.
struct alignas(64) LaneScores {
  double score[kScoredAtOnce];
  double seen_radpm[kScoredAtOnce];  ///< visibility times visible angle of one metre of error
};

/// What is known of eight pairs beside where their bodies are, one a lane.
struct alignas(64) LanePairs {
  std::uint32_t a[kScoredAtOnce], b[kScoredAtOnce];  ///< slots of bodies, a plane always second
  const solver::ContactPoint* point[kScoredAtOnce];  ///< the first of those that are cached, or any
  double with_points[kScoredAtOnce];                 ///< 1: there is one, else 0
  double with_plane[kScoredAtOnce];                  ///< 1: b is a plane, else 0
  double by_roots[kScoredAtOnce];  ///< 1: its separation is that of the root spheres, else separation_m
  double separation_m[kScoredAtOnce], error_m[kScoredAtOnce];  ///< as far as it is known, and what is expected of that
  double extent_m[kScoredAtOnce];                              ///< PairView::extent_m
  double importance[kScoredAtOnce];
  double waiting[kScoredAtOnce];                              ///< the factor of the cue
  double gain_m[kScoredAtOnce];                               ///< the best fall of the error per unit of work, metres
  double spin_a[3][kScoredAtOnce], spin_b[3][kScoredAtOnce];  ///< rad/s
  bool any_points = false;
};

/// What all pairs of a frame share.
struct LaneTerms {
  const collision::Pose* poses;     ///< one a slot
  const BodyBounds* bounds;         ///< likewise
  const scheduler::Policy* policy;  ///< one that scores_in_lanes
  const ViewQuery* view;
};

/// The scores of as many pairs as there are lanes. The same as scheduler::score() of their cues, but for the rounding
/// and the arc cosine, which is wrong by at most 1e-7 rad. Any thread.
void score_lanes(const LaneTerms& terms, const LanePairs& pairs, LaneScores& scores);

/// Gathers the pairs of one frame for that. One thread.
class LaneScorer {
 public:
  static constexpr std::size_t kMostPairs = PairTable::kMostOfChunk;
  /// The score of some pairs, and how well they are seen (LaneScores), one each.
  struct Scored {
    std::array<LaneScores, kMostPairs / kScoredAtOnce> of_lanes;
    [[nodiscard]] double score(std::size_t k) const { return of_lanes[k / kScoredAtOnce].score[k % kScoredAtOnce]; }
    [[nodiscard]] double seen_radpm(std::size_t k) const {
      return of_lanes[k / kScoredAtOnce].seen_radpm[k % kScoredAtOnce];
    }
  };

  /// `input` must live as long.
  explicit LaneScorer(const RefineInput& input);
  LaneScorer(const LaneScorer&) = delete;
  LaneScorer& operator=(const LaneScorer&) = delete;
  /// Of at most kMostPairs pairs of which no level is completed in this frame.
  void score(std::span<const std::uint32_t> pairs, std::span<const PairProgress> progress, Scored& scored);

 private:
  // What is the same of all pairs of two shapes, unless something is known of them.
  struct OfShapes {
    const ShapeFacts* a = nullptr;
    const ShapeFacts* b = nullptr;
    std::uint32_t next_units = 0;
    Level deepest = 0;
    bool polygons = false;
    float error_m[kPolygonBin + 1];   // of each level
    double of_work[kPolygonBin + 1];  // 1 / what it takes to come there from level 0
    double gain_m = 0;                // where nothing is known
  };
  void gather(std::uint32_t index, const PairProgress& progress, LanePairs& into, std::size_t lane);
  const OfShapes& of_shapes(const ActivePair& pair, const PairProgress& progress);
  [[nodiscard]] static double gain_m(const OfShapes& shapes, std::size_t known_level, float known_m);

  const RefineInput& input_;
  ViewQuery view_;
  LaneTerms terms_;
  std::array<LanePairs, kMostPairs / kScoredAtOnce> pairs_;
  OfShapes shapes_;
};

}  // namespace poise::simulation
