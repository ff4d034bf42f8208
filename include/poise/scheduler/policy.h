// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "poise/scheduler/bands.h"
#include "poise/scheduler/host_cue.h"
#include "poise/scheduler/problem.h"

namespace poise::scheduler {

/// How the next refinement is chosen.
enum class PolicyKind : std::uint8_t {
  Perceptual,  ///< largest noticeable gain per unit of work first
  Fifo,        ///< first in, first out; a refined pair goes to the back
  Random,      ///< a random order of each frame, from the seed
  Custom,      ///< the host's own function: Policy::custom
};

/// The visible angle of one metre of error without a view: that of 1 m at 10 m. Chosen.
inline constexpr double kDefaultPlainAngleRadpm = 0.1;

/// The cues of a pair: what a viewer can notice of it. A number that is NaN or negative counts as 0.
struct PairCues {
  double visibility = 1;                         ///< Policy::outside_frustum outside the frustum, else 1; in (0, 1]
  double angle_radpm = kDefaultPlainAngleRadpm;  ///< visible angle of one metre of error at the pair, rad/m, >= 0
  double eccentricity_rad = 0;                   ///< angle between gaze and pair, [0, pi]
  double closing_mps = 0;                        ///< approach speed of the two centres, >= 0
  double importance = 1;                         ///< >= 0
  std::uint32_t frames_waited = 0;               ///< frames since the pair was last refined
  float host = 1;                                ///< HostFactor::factor
};

/// Cost and expected gain of refining a pair further.
struct PairChain {
  std::uint64_t pair_id = 0;        ///< identifies the pair across frames
  std::uint32_t level = 0;          ///< the completed level
  std::span<const float> error_m;   ///< expected error of each level, from 0 to the pair's deepest, metres
  std::uint64_t front_entries = 1;  ///< cost of the next level in node-pair expansions
  UserData user_data{};             ///< of the two bodies, for a host's policy
  bool begun = false;               ///< a level of it was completed in this frame: its data is at hand
};

/// Facts of a frame that a policy may use.
struct FrameFacts {
  std::uint64_t frame = 0;
  std::uint64_t seed = 1;
  std::uint32_t deepest_level = 0;  ///< over all pairs; >= 1 if there is something to refine
  std::uint32_t pairs = 1;          ///< number that can be refined
};

/// A host's own policy: the score of a pair from the facts of the frame, the pair's chain, its cues and the user data
/// of its bodies. Larger scores are served sooner. NaN and values that are not positive count as 0, values above
/// kMostScore as kMostScore. With a wall clock, scores are distinguished in quarters of an octave from 2^-32 to 2^32.
///
/// The function must be pure and must not throw. Any thread may call it, several at once. It is called whenever a pair
/// enters the queue: before refinement begins, and after each level that is not the deepest. For records see HostCue.
struct HostPolicy {
  using Function = double (*)(const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
                              void* context) noexcept;
  Function function = nullptr;
  void* context = nullptr;  ///< passed to the function; must live as long as the policy is used
};

/// A policy is plain data: a rule, the weights of its cues, its parameters and a host's functions. first_problem()
/// checks all ranges. A policy without a problem gives a finite score >= 0 for any cues and chain.
struct Policy {
  PolicyKind kind = PolicyKind::Perceptual;

  // Weights. Each cue is a factor of the score, raised to its weight; weight 0 turns the cue off.
  double frustum = 1;       ///< visibility: 1 in the frustum, outside_frustum outside it
  double size = 1;          ///< the visible angle of one metre of error, relative to plain_angle_radpm
  double eccentricity = 1;  ///< 1 / (1 + E / eccentricity_e2_rad)
  double closing = 1;       ///< 1 + closing speed / closing_scale_mps
  double waiting = 1;       ///< 1 + frames since the pair was last refined
  double importance = 1;    ///< the factor that the scene gives to the two bodies
  double host = 1;          ///< the host's own cue, `cue`

  // Parameters.
  /// Visibility outside the frustum. Never zero, since hidden motion may come into view later. Chosen.
  double outside_frustum = 0.05;
  /// Eccentricity at which the threshold of acuity has doubled, 2.5 degrees (Strasburger, Rentschler and Juettner
  /// 2011).
  double eccentricity_e2_rad = 2.5 * 3.14159265358979323846 / 180.0;
  /// Closing speed that doubles the weight of a pair. Chosen.
  double closing_scale_mps = 1;
  /// The visible angle of one metre of error, rad/m, if the size cue is off or there is no view. Only a common factor.
  double plain_angle_radpm = kDefaultPlainAngleRadpm;
  /// Probability that a refinement separates the pair, before anything is learned. Chosen: one half, since nothing is
  /// known.
  double chance_of_ending = 0.5;
  /// Expected growth of a front from level to level. Measured on the shipped scenes: 1.5 to 3.
  double front_growth = 2;
  /// Overhead of starting a job, in node-pair expansions. Measured: about 100 ns, at 25 to 40 ns an expansion.
  double job_overhead_units = 4;
  /// Wall clock: units of work between two readings of the clock. At 25 to 40 ns an expansion, 512 units take 15 to 20
  /// us, which stays within 50 us on a machine half as fast.
  std::uint32_t quantum_units = 512;
  /// Work clock: pairs that are selected in one round.
  std::uint32_t round_pairs = 512;

  // Functions of the host. No file can hold them.
  HostCue cue{};  ///< a factor beside the others; used by Perceptual, and by a host's policy that reads PairCues::host
  HostPolicy custom{};  ///< must be set if kind is Custom
};

/// A weight or parameter of a policy that is a real number: its name, the member that holds it, and its range, both
/// ends included.
struct PolicyField {
  std::string_view name;
  double Policy::*value;
  double least;
  double most;
};
/// The same for a parameter that is a count.
struct PolicyCount {
  std::string_view name;
  std::uint32_t Policy::*value;
  std::uint32_t least;
  std::uint32_t most;
};
/// The weights of the cues, in the order of Policy; for code that reads, writes or checks policies.
std::span<const PolicyField> policy_weights();
/// The parameters that are real numbers, in the order of Policy.
std::span<const PolicyField> policy_parameters();
/// The parameters that are counts.
std::span<const PolicyCount> policy_counts();

/// The first field that is NaN or out of range; empty if the policy is valid. Any thread.
std::optional<Problem> first_problem(const Policy& policy);
/// Whether a policy has no problem.
inline bool valid(const Policy& policy) { return !first_problem(policy).has_value(); }

/// The largest factor of one cue, and the largest score. Chosen so that products of all factors stay finite.
inline constexpr double kMostFactor = 1e40;
inline constexpr double kMostScore = 1e300;

/// The product of the factors of all cues, >= 0 and finite. `policy` must be valid. Any thread.
double cue_weight(const Policy& policy, const PairCues& cues);

/// The best average gain per unit of work over the remaining levels of the pair, radians per expansion: the greedy
/// choice on the concave envelope of its chain. The overhead of a pair that was begun is paid. 0 if no level is left.
/// `policy` must be valid. Any thread.
double best_gain_per_work(const Policy& policy, const PairChain& chain, double angle_radpm);

/// The score of a pair, in [0, kMostScore]. Pairs with a larger score are served sooner, ties by pair. `queue_index` is
/// the pair's index in this frame's queue, for Fifo. `policy` must be valid. Any thread; the same arguments give the
/// same bits.
double score(const Policy& policy, const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
             std::uint32_t queue_index);

/// The band of a score; kBands - 1 is served first. Monotone in the score. For Perceptual and Custom a band is a
/// quarter of an octave. Any thread.
std::uint32_t band_of(const Policy& policy, double score);

}  // namespace poise::scheduler
