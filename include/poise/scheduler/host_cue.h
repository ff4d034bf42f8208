// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

/// A host's own cue: a plain function from a viewer's view of a pair to a factor of the pair's score.
namespace poise::scheduler {

/// The host's values of the two bodies of a pair (BodyDefinition::user_data), in the pair's order (of a World: that of
/// slots); 0 by default.
struct UserData {
  std::uint64_t a = 0;
  std::uint64_t b = 0;
};

/// A viewer's view of a pair. Lengths in metres, world frame. Without a viewer the pair counts as in the frustum, gazed
/// at and at distance 0.
struct PairView {
  std::uint64_t pair_id = 0;  ///< identifies the pair across frames
  UserData user_data{};
  std::array<double, 3> point_m{};        ///< contact point, or the expected one
  std::array<double, 3> normal{0, 0, 1};  ///< approximately unit, from one body to the other
  double extent_m = 0;                    ///< radius of the smaller body
  double closing_mps = 0;                 ///< approach speed of the two surfaces at point_m, spin included, >= 0
  double importance = 1;                  ///< factor that the scene gives to the two bodies
  std::uint32_t frames_waited = 0;        ///< since the pair was last refined
  bool has_view = false;                  ///< whether there is a viewer
  bool in_frustum = true;
  double distance_m = 0;        ///< from the eye
  double angle_radpm = 0;       ///< visible angle of one metre of error
  double eccentricity_rad = 0;  ///< angle between gaze and pair, [0, pi]
  // As PairCues; 0 or false where the weight of the cue is 0, since then it is not measured.
  double gap_rad = 0;
  double delay_s = 0;
  double age_s = 0;
  double crowd = 0;
  bool hidden = false;
  bool attended = false;
};

/// A host's own cue. The function returns a factor in [0, kMostHostFactor]: 1 changes nothing, 0 gives the lowest
/// priority.
///
/// The function must be pure (the same arguments give the same bits; it reads only what does not change during a step)
/// and must not throw. Any thread may call it, several at once. It is called once a step for each pair that is ranked:
/// in steps that have a budget (without one nothing goes by it) all that can be refined, but under a deadline no more
/// than there is time for. At a microsecond a call, ten thousand pairs cost 10 ms, so keep it to some tens of
/// nanoseconds.
///
/// A record holds the levels that complete in a frame, so a replay needs neither the cue nor the policy. To get the
/// same bits *without* a record (work clock), set the same function with the same context.
struct HostCue {
  using Function = double (*)(const PairView& view, void* context) noexcept;
  Function function = nullptr;  ///< null: there is none
  void* context = nullptr;      ///< passed to the function; must live as long as the policy is used
};

/// The largest factor of a host's cue.
inline constexpr double kMostHostFactor = 1e6;

/// The checked result of a host's cue.
struct HostFactor {
  float factor = 1;  ///< finite, in [0, kMostHostFactor]; becomes PairCues::host
  /// The function returned NaN (counts as 1) or a value out of range (counts as the nearest end).
  bool refused = false;
};

/// Calls the host's cue and checks its result; the factor is 1 without a cue. Any thread.
HostFactor host_factor(const HostCue& cue, const PairView& view);

}  // namespace poise::scheduler
