// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace poise::solver {

/// Pairs that are solved side by side.
inline constexpr std::size_t kLanes = 8;

/// Changes of one body's motion within a step: v and w are changes of linear and angular velocity since its start; x
/// and q are changes of position and angle beyond those of the start velocities. One cache line in single precision.
template <class T>
struct alignas(16 * sizeof(T)) MotionChange {
  T v[3] = {}, w[3] = {}, x[3] = {}, q[3] = {};
  T unused[4] = {};
};

/// The part of it that a substep begins with.
template <class T>
struct alignas(8 * sizeof(T)) SpeedChange {
  T v[3] = {}, w[3] = {};
  T unused[2] = {};
};

/// Inverse inertia times mass, world frame, 1/m^2. This scaling keeps the numbers in the range of single precision
/// whatever the mass.
template <class T>
struct alignas(8 * sizeof(T)) ScaledInverseInertia {
  T inertia[6] = {};  ///< xx, yy, zz, xy, xz, yz; 0 for what is not dynamic
  T unused[2] = {};
};

/// The k-th contact points of the eight pairs of a block. Impulses are divided by the reduced mass of the pair
/// (PairLanes::reduced_mass), so their unit is m/s.
template <class T>
struct alignas(64) PointLanes {
  T normal[3][kLanes] = {};
  T arm[3][kLanes] = {};   ///< from a
  T rate[3][kLanes] = {};  ///< velocity of a against b there at the start of the step
  T gap[kLanes] = {};
  T certain[kLanes] = {};  ///< with the slop
  T mass[kLanes] = {};     ///< effective mass along the normal, divided by the reduced mass; 0 for an inactive lane
  T across[kLanes] = {};   ///< the same along the tangent with the smallest effective mass
  T impulse[kLanes] = {};  ///< along the normal
  T friction_impulse[3][kLanes] = {};  ///< across it
  T left[kLanes] = {};  ///< of the gap, when a substep ends: the same in each of its iterations from the second one on
};

/// Normal and friction impulse of such contact points, summed over the substeps; likewise in m/s. Not set by itself:
/// each iteration of a block has some at hand that few write.
template <class T>
struct alignas(64) TotalLanes {
  T total[3][kLanes];
};

/// What one iteration a substep adds to the totals. The impulses of a substep are those that the next one begins with,
/// so the last of two substeps knows both, and between them nothing need be kept.
struct SubstepTotals {
  bool carried = false;  ///< to what is there, instead of to 0
  bool before = false;   ///< the impulses that the substep began with
  bool after = true;     ///< those that it ended with; without them nothing is added
};

/// What all contact points of a pair share, for the pairs of a block. Inverse masses are divided by the sum of both, so
/// that all numbers fit single precision whatever the masses.
template <class T>
struct alignas(64) PairLanes {
  T a_to_b[3][kLanes] = {};
  T dynamic_a[kLanes] = {}, dynamic_b[kLanes] = {};  ///< inverse mass as a share of that of both
  T friction[kLanes] = {};
  T reduced_mass[kLanes] = {};  ///< 1 / (sum of inverse masses); 0 for a lane that is not in use
  T shift[3][kLanes] = {};      ///< out: what moved b beyond its velocity so far, and a the opposite way, as a position
                                ///< impulse divided by the reduced mass, m
};

/// Further input of prepare_block. Not set by itself, likewise.
template <class T>
struct alignas(64) StartLanes {
  T velocity[3][kLanes];  ///< of a against b
  T spin_a[3][kLanes], spin_b[3][kLanes];
  T restitution[kLanes];
};

/// Up to eight pairs of one colour, which push no dynamic body, and no copy of one, twice.
struct ContactBlock {
  std::uint32_t a[kLanes] = {}, b[kLanes] = {};
  std::uint32_t pair[kLanes] = {};            ///< indices in ContactSystem::pairs
  std::uint32_t begin = 0;                    ///< of its pairs in the order of the colouring
  std::uint32_t first = 0;                    ///< of the lanes
  std::uint8_t count = 0;                     ///< lanes in use
  std::uint8_t manifold_points = 0;           ///< the most that a pair has
  std::uint8_t dynamic_a = 0, dynamic_b = 0;  ///< bit by lane
  bool frictional = true;                     ///< a pair has friction
  std::uint8_t pushed = 0;                    ///< bit by lane: something certainly penetrates and was pushed
  std::uint8_t shifted = 0;  ///< bit by lane: its shift changed the angular momentum (angular_balance.h)
};

/// One substep.
template <class T>
struct SubstepTerms {
  T h_s = 0;
  T begun_s = 0;  ///< since the start of the step
  T still_mps = 0;
  T push_share = 0;
  T most_push_m = 0;
  T relaxation = 1;    ///< of an iteration: each point makes so many times the change that it asks for, in (0, 2)
  bool watch = false;  ///< measure what the iteration changes (IterationChange), add nothing to totals
  SubstepTotals totals;
};

/// What a iteration changed.
template <class T>
struct IterationChange {
  T largest_ns = 0;      ///< largest impulse
  T change_ns = 0;       ///< largest change of one
  T change_mps = 0;      ///< largest change of an approach speed, or of a tangential speed by friction
  T impulse_sum_ns = 0;  ///< sum of the impulses
  T residual_j = 0;      ///< sum of the impulses, each times the change of its approach
};

/// Motion changes and inverse inertias, one of each a body.
template <class T>
struct BodyLanes {
  MotionChange<T>* motions = nullptr;
  const ScaledInverseInertia<T>* scaled_inverse_inertias = nullptr;
};

/// What all blocks of a step share.
struct BlockTerms {
  double still_mps = 0;  ///< what closes more slowly does not rebound
  double step_s = 0;
  double substep_s = 0;
};

/// Completes the lanes of a block: normal, arm, gaps and impulses of its contact points are there. Contact points that
/// close fast enough to rebound answer nothing. What a kinematic body carries around is to follow it along the chord of
/// its way in the step: along the tangent it would move outwards in each step.
void prepare_block(const ContactBlock& block, const PairLanes<float>& pairs, const StartLanes<float>& start,
                   const BlockTerms& terms, std::span<PointLanes<float>> manifold_points,
                   const ScaledInverseInertia<float>* scaled_inverse_inertias);
void prepare_block(const ContactBlock& block, const PairLanes<double>& pairs, const StartLanes<double>& start,
                   const BlockTerms& terms, std::span<PointLanes<double>> manifold_points,
                   const ScaledInverseInertia<double>* scaled_inverse_inertias);

/// Warm starts a block: applies the accumulated impulses of its contact points to its bodies.
void warm_start_block(const ContactBlock& block, const PairLanes<float>& pairs,
                      std::span<const PointLanes<float>> manifold_points, const BodyLanes<float>& bodies);
void warm_start_block(const ContactBlock& block, const PairLanes<double>& pairs,
                      std::span<const PointLanes<double>> manifold_points, const BodyLanes<double>& bodies);

/// What an iteration reads and writes of a block. By reference, so that it is in registers: spans that were just put on
/// the stack are waited for.
template <class T>
struct SolvedLanes {
  PairLanes<T>& pairs;
  std::span<PointLanes<T>> manifold_points;
  std::span<TotalLanes<T>> totals;  ///< one an entry of `manifold_points`
};

/// Solves the contact points of a block one after another, the normal impulse before friction. `iteration` counts those
/// of the substep from 0 on: in the first one certain penetration is corrected by moving the bodies apart, and later
/// ones move nothing. Without terms.watch it is the only one, and the totals are those of terms.totals.
IterationChange<float> solve_block(ContactBlock& block, const SolvedLanes<float>& lanes,
                                   const SubstepTerms<float>& terms, std::uint32_t iteration,
                                   const BodyLanes<float>& bodies);
IterationChange<double> solve_block(ContactBlock& block, const SolvedLanes<double>& lanes,
                                    const SubstepTerms<double>& terms, std::uint32_t iteration,
                                    const BodyLanes<double>& bodies);

}  // namespace poise::solver
