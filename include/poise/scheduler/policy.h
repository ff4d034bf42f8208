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
  Perceptual,  ///< most noticeable gain per unit of work first
  Fifo,        ///< first come, first served; a refined pair goes to the back
  Random,      ///< an order drawn anew each frame from the seed
  Custom,      ///< the host's own: Policy::custom
};

/// The visible angle of one metre of error where nothing is known of the view: 1 rad at 10 m. Chosen.
inline constexpr double kDefaultPlainAngleRadpm = 0.1;

/// What a viewer can notice of a pair. A number that is NaN or negative counts as 0.
struct PairCues {
  double visibility = 1;                         ///< in (0, 1]
  double angle_radpm = kDefaultPlainAngleRadpm;  ///< visible angle of one metre of error at the pair, rad/m, >= 0
  double eccentricity_rad = 0;                   ///< angle between gaze and pair, [0, pi]
  double closing_mps = 0;                        ///< approach speed of the two centres, >= 0
  double importance = 1;                         ///< >= 0
  std::uint32_t frames_waited = 0;
  float host = 1;  ///< HostFactor::factor
};

/// What refining a pair further would cost and bring.
struct PairChain {
  std::uint64_t pair_id = 0;        ///< names the pair over frames
  std::uint32_t level = 0;          ///< completed
  std::span<const float> error_m;   ///< expected error of each level from 0 to the deepest of the pair, metres
  std::uint64_t front_entries = 1;  ///< = node-pair expansions of the next level
  UserData user_data{};             ///< of the two bodies, for a host's policy
};

/// Per-frame facts that a policy may use.
struct FrameFacts {
  std::uint64_t frame = 0;
  std::uint64_t seed = 1;
  std::uint32_t deepest_level = 0;  ///< of any pair, >= 1 when there is something to refine
  std::uint32_t pairs = 1;          ///< that can be refined
};

/// A host's own policy: the score of a pair from what is known of the frame, the pair's chain, its cues and the user
/// data of its bodies. Larger is served sooner; what is NaN or not positive counts as 0, what is above kMostScore as
/// that. Under the wall clock scores are told apart by quarters of an octave from 2^-32 to 2^32.
///
/// What it must hold: it is pure, it does not throw, and it may be called from any thread, several at once. It is
/// called whenever a pair is put into the queue: before refinement begins, and after each level that leaves deeper
/// ones. What is recorded are the levels that complete; see HostCue.
struct HostPolicy {
  using Function = double (*)(const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
                              void* context) noexcept;
  Function function = nullptr;
  void* context = nullptr;  ///< handed to the function; lives as long as the policy is used
};

/// A policy is data: a rule, the weights of its cues, its parameters and what a host adds. first_problem() says what
/// each may be; a policy without a problem gives a finite score >= 0 for any cues and chain.
struct Policy {
  PolicyKind kind = PolicyKind::Perceptual;

  // Weights: each cue is a factor of the score, raised to its weight; weight 0 switches the cue off.
  double frustum = 1;       ///< visibility: 1 in the frustum, outside_frustum beside it
  double size = 1;          ///< the visible angle of one metre of error, against plain_angle_radpm
  double eccentricity = 1;  ///< 1 / (1 + E / eccentricity_e2_rad)
  double closing = 1;       ///< 1 + closing speed / closing_scale_mps
  double waiting = 1;       ///< 1 + frames since the pair was last refined
  double importance = 1;    ///< the importance that the scene gives to the two bodies
  double host = 1;          ///< the host's own cue, `cue`

  // Parameters.
  /// Visibility of what is outside the frustum. Never zero: hidden motion comes back into view. Chosen.
  double outside_frustum = 0.05;
  /// Eccentricity at which the threshold of acuity has doubled, 2.5 degrees (Strasburger, Rentschler and Juettner
  /// 2011).
  double eccentricity_e2_rad = 2.5 * 3.14159265358979323846 / 180.0;
  /// Closing speed that doubles the weight of a pair. Chosen.
  double closing_scale_mps = 1;
  /// The visible angle of one metre of error where the size cue is off or there is no view. A common factor only.
  double plain_angle_radpm = kDefaultPlainAngleRadpm;
  /// Chance that a refinement ends the contact, before anything is learned. Chosen (a half: nothing is known).
  double chance_of_ending = 0.5;
  /// By how much a front is expected to grow from level to level. Measured on the shipped scenes: 1.5 to 3.
  double front_growth = 2;
  /// Work of starting a job, in node-pair expansions. Measured: about 100 ns against 25 to 40 ns an expansion.
  double job_overhead_units = 4;
  /// Wall clock: units of work that are done between two looks at the clock. At 25 to 40 ns an expansion 512 are 15 to
  /// 20 us, within the quantum of 50 us also on a machine half as fast.
  std::uint32_t quantum_units = 512;
  /// Work clock: pairs that are chosen at once.
  std::uint32_t round_pairs = 512;

  // What a host adds. No file can say these.
  HostCue cue{};  ///< a factor beside the others, for Perceptual and for a host's policy that reads PairCues::host
  HostPolicy custom{};  ///< must be set where kind is Custom
};

/// A weight or parameter of a policy that is a real number: its name, where it is, and its range, both ends allowed.
struct PolicyField {
  std::string_view name;
  double Policy::*value;
  double least;
  double most;
};
/// Likewise one that is a count.
struct PolicyCount {
  std::string_view name;
  std::uint32_t Policy::*value;
  std::uint32_t least;
  std::uint32_t most;
};
/// The weights of the cues, in the order of Policy; for who reads, writes or checks policies.
std::span<const PolicyField> policy_weights();
/// The parameters that are real numbers, in the order of Policy.
std::span<const PolicyField> policy_parameters();
/// The parameters that are counts.
std::span<const PolicyCount> policy_counts();

/// The first field that is NaN or out of its range; none: the policy may be used. Any thread.
std::optional<Problem> first_problem(const Policy& policy);
inline bool valid(const Policy& policy) { return !first_problem(policy).has_value(); }

/// The largest factor that one cue can make, and the largest score. Chosen: products of all factors stay finite.
inline constexpr double kMostFactor = 1e40;
inline constexpr double kMostScore = 1e300;

/// The factor that all cues make together, >= 0 and finite. `policy` has no problem.
double cue_weight(const Policy& policy, const PairCues& cues);

/// The best average gain per unit of work over the remaining levels of the pair, radians per expansion: the greedy
/// choice on the concave envelope of its chain. 0 when no level is left. `policy` has no problem.
double best_gain_per_work(const Policy& policy, const PairChain& chain, double angle_radpm);

/// What decides the order: larger is sooner, ties by pair; in [0, kMostScore]. `queue_index` is the place of the pair
/// in this frame's queue, for Fifo. `policy` has no problem. Any thread; the same arguments give the same bits.
double score(const Policy& policy, const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
             std::uint32_t queue_index);

/// The band that a score belongs to, kBands - 1 is served first. Monotone in the score. For Perceptual and
/// Custom a band is a quarter of an octave.
std::uint32_t band_of(const Policy& policy, double score);

}  // namespace poise::scheduler
