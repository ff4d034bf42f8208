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
struct alignas(64) PatchLanes {
  DirectionLanes<T> normal;
  T gap[kLanes] = {};
  T surely[kLanes] = {};                      ///< with the slop
  T impulse[kLanes] = {}, total[kLanes] = {}; ///< in units
  T newton_s[kLanes] = {};                    ///< a unit in N s; 0 for a lane that answers nothing
};

/// Friction at the same places.
template <class T>
struct alignas(64) FrictionLanes {
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
  bool rubs = true;                           ///< a pair has friction
  std::uint8_t pushed = 0;                    ///< bit by lane: something overlaps beyond doubt and was pushed
};

/// One side of the pairs of a block.
template <class T>
struct alignas(64) SideLanes {
  T yield[kLanes] = {};                       ///< inverse mass as a share of that of both
  T inertia[6][kLanes] = {};                  ///< inverse inertia likewise: xx, yy, zz, xy, xz, yz
  T spin[3][kLanes] = {};
};

/// The pairs of a block, and of each one place. Masses are in shares of the inverse masses of both bodies together, so that nothing leaves single
/// precision whatever they are.
template <class T>
struct alignas(64) PairLanes {
  SideLanes<T> a, b;
  T a_to_b[3][kLanes] = {};
  T velocity[3][kLanes] = {};                 ///< of a against b
  T restitution[kLanes] = {}, friction[kLanes] = {};
  T newton_s[kLanes] = {};                    ///< 1 / (sum of inverse masses); 0 for a lane that is not in use
};
template <class T>
struct alignas(64) PlaceLanes {
  T normal[3][kLanes] = {}, arm[3][kLanes] = {};
  T impulse[kLanes] = {}, rubbed[3][kLanes] = {};  ///< to start with, in newton_s of the pair
};

/// Makes the lanes of the k-th patches from the pairs and their places; `friction` may be null. Places that close fast enough to rebound answer nothing.
void prepare_patch(const PairLanes<float>& pairs, const PlaceLanes<float>& places, float still_mps, PatchLanes<float>& patch, FrictionLanes<float>* friction);
void prepare_patch(const PairLanes<double>& pairs, const PlaceLanes<double>& places, double still_mps, PatchLanes<double>& patch,
                   FrictionLanes<double>* friction);

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
