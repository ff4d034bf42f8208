// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace poise::response {

/// Pairs that are solved side by side.
inline constexpr std::size_t kLanes = 8;

/// What a step changes in the motion of one body: velocity and spin on top of those at its start, place and angle on top of where these alone
/// would lead. One cache line in single precision.
template <class T>
struct alignas(16 * sizeof(T)) Motion {
  T v[3] = {}, w[3] = {}, x[3] = {}, q[3] = {};
  T unused[4] = {};
};

/// One direction at eight places: l with its moments, and what an impulse of one unit changes. A unit is the impulse that changes the approach by 1 m/s,
/// so all numbers are of the size of velocities and lengths whatever the masses.
template <class T>
struct alignas(64) DirectionLanes {
  T l[3][kLanes] = {}, ta[3][kLanes] = {}, tb[3][kLanes] = {};
  T ua[3][kLanes] = {}, ub[3][kLanes] = {};   ///< M I^-1 t
  T ma[kLanes] = {}, mb[kLanes] = {};         ///< M / m; 0 for what does not yield
  T rate[kLanes] = {};                        ///< approach at the start of the step
};

/// The eight k-th patches of the pairs of a block.
template <class T>
struct PatchLanes {
  DirectionLanes<T> normal;
  T gap[kLanes] = {};
  T surely[kLanes] = {};                      ///< with the slop
  T impulse[kLanes] = {}, total[kLanes] = {}; ///< in units
  T newton_s[kLanes] = {};                    ///< a unit in N s; 0 for a lane that answers nothing
};

/// Friction at the same places.
template <class T>
struct FrictionLanes {
  DirectionLanes<T> along[2];
  T share[kLanes] = {};                       ///< a unit along a tangent in units along the normal
  T coefficient[kLanes] = {};
  T impulse[2][kLanes] = {}, total[2][kLanes] = {};
};

/// Up to eight pairs of one colour, which share no yielding body.
struct RestBlock {
  std::uint32_t a[kLanes] = {}, b[kLanes] = {};
  std::uint32_t pair[kLanes] = {};            ///< places in RestSystem::pairs
  std::uint32_t count = 0;                    ///< lanes in use
  std::uint32_t patches = 0;                  ///< the most that a pair has
  std::uint32_t first = 0;                    ///< of the lanes
  std::uint8_t yields_a = 0, yields_b = 0;    ///< bit by lane
  std::uint8_t pushed = 0;                    ///< bit by lane: something overlaps beyond doubt and was pushed
};

/// One substep.
template <class T>
struct SubstepTerms {
  T h_s = 0;
  T begun_s = 0;                              ///< since the start of the step
  T still_mps = 0;
  T push_share = 0;
  T most_push_m = 0;
  bool watch = false;                         ///< find out what the sweep changes
};

/// What a sweep changed.
template <class T>
struct SweepChange {
  T largest_ns = 0;                           ///< largest impulse
  T change_ns = 0;                            ///< largest change of one
  T change_mps = 0;                           ///< the largest in units: by how much it changed an approach
};

/// Gives the bodies of a block the impulses that its patches start with.
void warm_block(RestBlock& block, std::span<const PatchLanes<float>> patches, std::span<const FrictionLanes<float>> friction, Motion<float>* motions);
void warm_block(RestBlock& block, std::span<const PatchLanes<double>> patches, std::span<const FrictionLanes<double>> friction, Motion<double>* motions);

/// Solves the patches of a block one after another, friction before the normal: `friction` may be empty. With `push`, what overlaps
/// beyond doubt is pushed apart.
SweepChange<float> solve_block(RestBlock& block, std::span<PatchLanes<float>> patches, std::span<FrictionLanes<float>> friction,
                               const SubstepTerms<float>& terms, bool push, Motion<float>* motions);
SweepChange<double> solve_block(RestBlock& block, std::span<PatchLanes<double>> patches, std::span<FrictionLanes<double>> friction,
                                const SubstepTerms<double>& terms, bool push, Motion<double>* motions);

}  // namespace poise::response
