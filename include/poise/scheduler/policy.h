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
  Perceptual,   ///< largest noticeable gain per unit of work first
  Fifo,         ///< first in, first out; a refined pair goes to the back
  Random,       ///< a random order of each frame, from the seed
  Custom,       ///< the host's own function: Policy::custom
  RoundRobin,   ///< groups near the gaze, in the frustum and outside it; a level of each pair in turn within a group
  Size,         ///< largest visible error first, whatever its removal costs
  Deepest,      ///< the pair that was refined deepest goes on, to its end
  EqualLevels,  ///< all pairs on one level before any goes deeper, those first that have waited longest
};
inline constexpr PolicyKind kLastPolicyKind = PolicyKind::EqualLevels;

/// The visible angle of one metre of error without a view: that of 1 m at 10 m. Chosen.
inline constexpr double kDefaultPlainAngleRadpm = 0.1;

/// The cues of a pair: what a viewer can notice of it. A number that is NaN or, but for the separation,
/// negative counts as 0. A cue whose weight
/// is 0 is not measured and has its default here, but for visibility, angle and what costs nothing.
struct PairCues {
  double visibility = 1;                         ///< Policy::outside_frustum outside the frustum, else 1; in (0, 1]
  double angle_radpm = kDefaultPlainAngleRadpm;  ///< visible angle of one metre of error at the pair, rad/m, >= 0
  double eccentricity_rad = 0;                   ///< angle between gaze and pair, [0, pi]
  double closing_mps = 0;           ///< approach speed of the two surfaces at the contact point, spin included, >= 0
  std::uint32_t frames_waited = 0;  ///< frames since the pair was last refined
  float importance = 1;             ///< >= 0
  float host = 1;                   ///< HostFactor::factor
  float gap_rad = 0;  ///< visible angle of the separation or penetration of the pair as it was last answered, >= 0
  float delay_s = 0;  ///< for how long surfaces that approach were not refined: the response may be so late, >= 0
  float age_s = 0;    ///< since the contact began; 0: it begins now or later, >= 0
  /// Separation of the surfaces as far as it is known, over the error that is expected of that; negative where they
  /// overlap.
  float separation = 0;
  std::uint16_t crowd = 0;  ///< other events near by on the screen, at most 65535
  bool hidden = false;      ///< all that moves of the pair is surely behind other bodies
  bool attended = false;    ///< the host's attention is on it (StepInput::attention)
};

/// Cost and expected gain of refining a pair further.
struct PairChain {
  std::uint64_t pair_id = 0;        ///< identifies the pair across frames
  std::uint32_t level = 0;          ///< the completed level
  std::span<const float> error_m;   ///< expected error of each level, from 0 to the pair's deepest, metres
  std::uint64_t front_entries = 1;  ///< cost of the next level in node-pair expansions
  UserData user_data{};             ///< of the two bodies, for a host's policy
  bool begun = false;               ///< a level of it was completed in this frame: its data is at hand
  std::uint32_t last_level = 0;     ///< by which the pair was answered in the frame before
  /// Of each level, from 0: for how many frames what it finds is valid. Empty: 1.
  std::span<const float> lifetime_frames = {};
  /// Of each level, from 0: probability that it or a level before it finds the pair separated. Empty: chance_of_ending
  /// for any deeper level.
  std::span<const float> ended = {};
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
/// enters the queue: before refinement begins, and after each level that is not the deepest. Under a deadline a thread
/// that the system holds up may still call it after the step has returned: World::wait_for_workers. For records see
/// HostCue.
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
  double occlusion = 0;     ///< 1, or hidden_visibility where the pair is hidden behind other bodies
  double gap = 0;           ///< 1 + visible gap or penetration / gap_scale_rad
  double delay = 0;         ///< 1 + delay of the response / delay_scale_s
  double onset = 0;         ///< 1 + 1 / (1 + age of the contact / onset_scale_s)
  double crowding = 0;      ///< 1 / (1 + other events near by on the screen / crowding_scale)
  double attention = 0;     ///< attention_factor where the host's attention is, else 1
  double hysteresis = 0;    ///< hysteresis_factor for levels up to that of the frame before, else 1
  double touch = 1;         ///< root of twice the chance that the surfaces touch: sqrt(1 - s / sqrt(1 + s^2))

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
  /// Visibility of a pair that is hidden. Never zero, as outside_frustum. Chosen; docs/reference.md uses the same.
  double hidden_visibility = 0.25;
  /// Visible gap that doubles the weight of a pair: 10 minutes of arc. Chosen, at ten times the acuity of the fovea.
  double gap_scale_rad = 10 * 3.14159265358979323846 / (180.0 * 60.0);
  /// Delay that doubles the weight of a pair. Chosen; with 0.1 to 0.15 s a collision no longer looks like a cause
  /// (Michotte 1946).
  double delay_scale_s = 0.1;
  /// Age of a contact at which half of what its onset adds to the weight is left. Chosen, as delay_scale_s.
  double onset_scale_s = 0.1;
  /// Events near by that halve the weight of a pair. Chosen.
  double crowding_scale = 8;
  /// Factor of what the host's attention is on. Chosen.
  double attention_factor = 4;
  /// Factor of the gain of a level that the pair had in the frame before. Chosen.
  double hysteresis_factor = 2;
  /// Errors whose visible angle is below this, at the gaze, are not seen, and what is left of them is not refined; the
  /// threshold rises with eccentricity as 1 + E / eccentricity_e2_rad. 0: all are seen. An acuity of 20/20 is 1 minute
  /// of arc, 0.00029 rad.
  double seen_threshold_rad = 0;
  /// How much of the expected error, the chance of ending and the lifetime of levels is learned from the frames before:
  /// 0 nothing, 1 all.
  double learning = 0;
  /// Value of not having to answer a contact: radians of visible error for a unit of work. 0: only errors count.
  /// Chosen.
  double time_price_rad = 0;
  /// Work of answering a contact in a frame, in node-pair expansions; counts with time_price_rad. Chosen.
  double answer_units = 64;
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
/// The gain of level L' from level L is
///
///     angle * chance_of_ending * (error(L) - error(L')) * lifetime(L') * hysteresis
///         + time_price * ended(L to L') * answer_units * lifetime(L')
///
/// with the angle in rad/m, errors in metres, lifetimes in frames (docs/cues.md). `policy` must be valid. Any thread.
double best_gain_per_work(const Policy& policy, const PairChain& chain, double angle_radpm);

/// Whether the error that is left of a pair is above Policy::seen_threshold_rad. Any thread.
bool error_is_seen(const Policy& policy, const PairChain& chain, const PairCues& cues);

/// Whether any pair may be left out of refinement: with a threshold, what is not seen costs nothing.
inline bool leaves_out(const Policy& policy) {
  return policy.seen_threshold_rad > 0 && policy.kind == PolicyKind::Perceptual;
}
/// Whether a pair with this score is.
inline bool left_out(const Policy& policy, double score) { return score <= 0 && leaves_out(policy); }

/// The score of a pair, in [0, kMostScore]. Pairs with a larger score are served sooner, ties by pair. `queue_index` is
/// the pair's index in this frame's queue, for Fifo. `policy` must be valid. Any thread; the same arguments give the
/// same bits.
double score(const Policy& policy, const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
             std::uint32_t queue_index);

/// The band of a score; kBands - 1 is served first. Monotone in the score. For Perceptual, Custom and Size a band is a
/// quarter of an octave. Any thread.
std::uint32_t band_of(const Policy& policy, double score);
/// By how many bands a pair that has waited so many frames has its turn before one that has not, but for that the same.
/// Below kBands; 0 for policies other than Perceptual. Any thread.
std::uint32_t waited_bands(const Policy& policy, std::uint32_t frames);

}  // namespace poise::scheduler
