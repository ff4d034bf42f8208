// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

namespace poise::scheduler {

/// How the next refinement is chosen.
enum class PolicyKind : std::uint8_t {
  Perceptual,  ///< most noticeable gain per unit of work first
  Fifo,        ///< first come, first served; a refined pair goes to the back
  Random,      ///< an order drawn anew each frame from the seed
};

/// A policy is data: a rule and its weights. Each cue is a factor of the score, raised to its weight; weight 0 switches
/// the cue off. Weights must be finite and >= 0.
struct Policy {
  PolicyKind kind = PolicyKind::Perceptual;
  double frustum = 1;       ///< visibility: 1 in the frustum, kOutsideFrustum beside it
  double size = 1;          ///< the visible angle of one metre of error, against kPlainAngleRadpm
  double eccentricity = 1;  ///< 1 / (1 + E / E2)
  double closing = 1;       ///< 1 + closing speed / (1 m/s)
  double waiting = 1;       ///< 1 + frames since the pair was last refined
  double importance = 1;    ///< the importance that the scene gives to the two bodies
};

/// Visibility of what is outside the frustum. Never zero: hidden motion comes back into view. Chosen.
inline constexpr double kOutsideFrustum = 0.05;
/// Eccentricity at which the threshold of acuity has doubled, 2.5 degrees (Strasburger, Rentschler and Juettner 2011).
inline constexpr double kEccentricityE2Rad = 2.5 * 3.14159265358979323846 / 180.0;
/// The visible angle of one metre of error when the size cue is off: 1 rad at 10 m. Chosen; a common factor only.
inline constexpr double kPlainAngleRadpm = 0.1;
/// Chance that a refinement ends the contact, before anything is learned. Chosen (a half: nothing is known).
inline constexpr double kChanceOfEnding = 0.5;
/// By how much a front is expected to grow from level to level. Measured on the shipped scenes: 1.5 to 3.
inline constexpr double kFrontGrowth = 2.0;
/// Work of starting a job, in node-pair expansions. Measured: about 100 ns against 25 to 40 ns an expansion.
inline constexpr double kJobOverheadUnits = 4.0;

/// What a viewer can notice of a pair. Invariant to hold: every number finite.
struct PairCues {
  double visibility = 1;                  ///< in (0, 1]
  double angle_radpm = kPlainAngleRadpm;  ///< visible angle of one metre of error at the pair, rad/m, >= 0
  double eccentricity_rad = 0;            ///< angle between gaze and pair, [0, pi]
  double closing_mps = 0;                 ///< approach speed of the two centres, >= 0
  double importance = 1;                  ///< >= 0
  std::uint32_t frames_waited = 0;
};

/// What refining a pair further would cost and bring.
struct PairChain {
  std::uint64_t pair_id = 0;        ///< names the pair over frames
  std::uint32_t level = 0;          ///< completed
  std::span<const float> error_m;   ///< expected error of each level from 0 to the deepest of the pair, metres
  std::uint64_t front_entries = 1;  ///< = node-pair expansions of the next level
};

/// Per-frame facts that a policy may use.
struct FrameFacts {
  std::uint64_t frame = 0;
  std::uint64_t seed = 1;
  std::uint32_t deepest_level = 0;  ///< of any pair, >= 1 when there is something to refine
  std::uint32_t pairs = 1;          ///< that can be refined
};

/// The factor that all cues make together, >= 0 and finite.
double cue_weight(const Policy& policy, const PairCues& cues);

/// The best average gain per unit of work over the remaining levels of the pair, radians per expansion:
/// the greedy choice on the concave envelope of its chain. 0 when no level is left.
double best_gain_per_work(const PairChain& chain, double angle_radpm);

/// What decides the order: larger is sooner, ties by pair. `queue_index` is the place of the pair in this frame's
/// queue, for Fifo. Any thread; the same arguments give the same bits.
double score(const Policy& policy, const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
             std::uint32_t queue_index);

inline constexpr std::uint32_t kBands = 256;
/// The band that a score belongs to, kBands - 1 is served first. Monotone in the score. For Perceptual a band is a
/// quarter of an octave.
std::uint32_t band_of(const Policy& policy, double score);

/// Weights finite and >= 0?
bool valid(const Policy& policy);

}  // namespace poise::scheduler
