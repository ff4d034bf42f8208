// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

/// A host's own cue: a plain function from what a viewer sees of a pair to a factor of the pair's score.
namespace poise::scheduler {

/// What the host gave the two bodies of a pair, in the pair's order (of a World: that of slots); 0 where it gave
/// nothing.
struct UserData {
  std::uint64_t a = 0;
  std::uint64_t b = 0;
};

/// What a viewer sees of a pair. Lengths in metres, world frame. Without a view the pair counts as in the frustum,
/// gazed at and at no distance.
struct PairView {
  std::uint64_t pair_id = 0;  ///< names the pair over frames
  UserData user_data{};
  std::array<double, 3> point_m{};        ///< where the two meet, or would
  std::array<double, 3> normal{0, 0, 1};  ///< about unit, from one body to the other
  double extent_m = 0;                    ///< radius of the smaller body
  double closing_mps = 0;                 ///< approach speed of the two centres, >= 0
  double importance = 1;                  ///< that the scene gives to the two bodies
  std::uint32_t frames_waited = 0;        ///< since the pair was last refined
  bool has_view = false;                  ///< is there a viewer at all?
  bool in_frustum = true;
  double distance_m = 0;        ///< from the eye
  double angle_radpm = 0;       ///< visible angle of one metre of error
  double eccentricity_rad = 0;  ///< angle between gaze and pair, [0, pi]
};

/// A host's own cue. The function gives a factor in [0, kMostHostFactor]: 1 leaves the pair as it is, 0 puts it last.
///
/// What it must hold: it is pure (the same arguments give the same bits; it reads only what does not change during a
/// step), it does not throw, and it may be called from any thread, several at once. It is called once a pair in the
/// coarse stage, for pairs that can be refined; at a microsecond a call ten thousand pairs cost 10 ms, so keep it at
/// some tens of nanoseconds.
///
/// What is recorded: the levels that complete in a frame, so a replay needs neither the cue nor the policy. To run
/// again *without* a record and get the same bits (work clock), set the same function with the same context.
struct HostCue {
  using Function = double (*)(const PairView& view, void* context) noexcept;
  Function function = nullptr;  ///< null: there is none
  void* context = nullptr;      ///< handed to the function; lives as long as the policy is used
};

/// The largest factor of a host's cue.
inline constexpr double kMostHostFactor = 1e6;

struct HostFactor {
  float factor = 1;  ///< finite, in [0, kMostHostFactor]: PairCues::host
  bool refused =
      false;  ///< the function gave NaN (counts as 1) or what is out of range (the nearest end); to be counted
};

/// Asks the host's cue; 1 where there is none. Any thread.
HostFactor host_factor(const HostCue& cue, const PairView& view);

}  // namespace poise::scheduler
