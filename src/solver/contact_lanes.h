// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace poise::solver {

/// Pairs that are solved side by side.
inline constexpr std::size_t kLanes = 8;

/// What a step changes in the motion of one body: velocity and spin on top of those at its start, place and angle on
/// top of where these alone would lead. One cache line in single precision.
template <class T>
struct alignas(16 * sizeof(T)) Motion {
  T v[3] = {}, w[3] = {}, x[3] = {}, q[3] = {};
  T unused[4] = {};
};

/// How a body turns, world frame: inverse inertia times mass, 1/m^2, so that it is of the size of its measures whatever
/// its mass.
template <class T>
struct alignas(8 * sizeof(T)) AngularResponse {
  T inertia[6] = {};  ///< xx, yy, zz, xy, xz, yz; 0 for what does not yield
  T unused[2] = {};
};

/// The eight k-th places of the pairs of a block. Impulses are in the units of the pair (PairLanes::newton_s): those
/// that change the speed of the two against each other by 1 m/s if they do not turn.
template <class T>
struct alignas(64) PointLanes {
  T normal[3][kLanes] = {};
  T arm[3][kLanes] = {};   ///< from a
  T rate[3][kLanes] = {};  ///< velocity of a against b there at the start of the step
  T gap[kLanes] = {};
  T certain[kLanes] = {};              ///< with the slop
  T mass[kLanes] = {};                 ///< units that change the approach by 1 m/s; 0 for a lane that answers nothing
  T across[kLanes] = {};               ///< the same along the tangent that yields most
  T impulse[kLanes] = {};              ///< along the normal
  T friction_impulse[3][kLanes] = {};  ///< across it
  T total[3][kLanes] = {};             ///< of both, over the substeps that are over
};

/// What all places of the pairs of a block share. Masses are in shares of the inverse masses of both bodies together,
/// so that nothing leaves single precision whatever they are.
template <class T>
struct alignas(64) PairLanes {
  T a_to_b[3][kLanes] = {};
  T dynamic_a[kLanes] = {}, dynamic_b[kLanes] = {};  ///< inverse mass as a share of that of both
  T friction[kLanes] = {};
  T newton_s[kLanes] = {};  ///< 1 / (sum of inverse masses); 0 for a lane that is not in use
};

/// What making lanes needs of the pairs beyond that.
template <class T>
struct alignas(64) StartLanes {
  T velocity[3][kLanes] = {};  ///< of a against b
  T spin_a[3][kLanes] = {}, spin_b[3][kLanes] = {};
  T restitution[kLanes] = {};
};

/// Up to eight pairs of one colour, which share no yielding body.
struct RestBlock {
  std::uint32_t a[kLanes] = {}, b[kLanes] = {};
  std::uint32_t pair[kLanes] = {};            ///< places in RestSystem::pairs
  std::uint32_t begin = 0;                    ///< of its pairs in the order of the colouring
  std::uint32_t first = 0;                    ///< of the lanes
  std::uint8_t count = 0;                     ///< lanes in use
  std::uint8_t manifold_points = 0;           ///< the most that a pair has
  std::uint8_t dynamic_a = 0, dynamic_b = 0;  ///< bit by lane
  bool frictional = true;                     ///< a pair has friction
  std::uint8_t pushed = 0;                    ///< bit by lane: something overlaps beyond doubt and was pushed
};

/// One substep.
template <class T>
struct SubstepTerms {
  T h_s = 0;
  T begun_s = 0;  ///< since the start of the step
  T still_mps = 0;
  T push_share = 0;
  T most_push_m = 0;
  bool watch = false;  ///< find out what the sweep changes
};

/// What a sweep changed.
template <class T>
struct IterationChange {
  T largest_ns = 0;  ///< largest impulse
  T change_ns = 0;   ///< largest change of one
  T change_mps = 0;  ///< the largest change of an approach, or of what friction would have changed of it
  T load_ns = 0;     ///< sum of the impulses
  T strayed_j = 0;   ///< sum of the impulses, each times the change of its approach
};

/// The motions of a body and how it turns, one a body.
template <class T>
struct BodyLanes {
  Motion<T>* motions = nullptr;
  const AngularResponse<T>* angular_responses = nullptr;
};

/// Completes the lanes of a block: normal, arm, gaps and loads of its places are there. Places that close fast enough
/// to rebound answer nothing.
void prepare_block(const RestBlock& block, const PairLanes<float>& pairs, const StartLanes<float>& start,
                   float still_mps, std::span<PointLanes<float>> manifold_points,
                   const AngularResponse<float>* angular_responses);
void prepare_block(const RestBlock& block, const PairLanes<double>& pairs, const StartLanes<double>& start,
                   double still_mps, std::span<PointLanes<double>> manifold_points,
                   const AngularResponse<double>* angular_responses);

/// Gives the bodies of a block the impulses that its places start with.
void warm_block(const RestBlock& block, const PairLanes<float>& pairs,
                std::span<const PointLanes<float>> manifold_points, const BodyLanes<float>& bodies);
void warm_block(const RestBlock& block, const PairLanes<double>& pairs,
                std::span<const PointLanes<double>> manifold_points, const BodyLanes<double>& bodies);

/// Solves the places of a block one after another, the normal before friction. With `push`, what overlaps beyond doubt
/// is pushed apart. Without terms.watch it is the only sweep of the substep, and the totals are kept.
IterationChange<float> solve_block(RestBlock& block, const PairLanes<float>& pairs,
                                   std::span<PointLanes<float>> manifold_points, const SubstepTerms<float>& terms,
                                   bool push, const BodyLanes<float>& bodies);
IterationChange<double> solve_block(RestBlock& block, const PairLanes<double>& pairs,
                                    std::span<PointLanes<double>> manifold_points, const SubstepTerms<double>& terms,
                                    bool push, const BodyLanes<double>& bodies);

}  // namespace poise::solver
