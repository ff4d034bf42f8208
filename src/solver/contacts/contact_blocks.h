// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "parallel/unset_vector.h"
#include "solver/contacts/contact_lanes.h"
#include "solver/contacts/split_system.h"
#include "solver/lane_memory.h"

namespace poise::solver {

/// The memory of both precisions, which take turns.
struct LaneMemories {
  LaneMemory pairs, manifold_points, totals, motions, begun, scaled_inverse_inertias;
};

// Lanes and motions in one precision.
template <class T>
struct Lanes {
  std::span<PairLanes<T>> pairs;  // one a block
  std::span<PointLanes<T>> manifold_points;
  std::span<TotalLanes<T>> totals;     // beside them, where they are kept from substep to substep
  std::span<MotionChange<T>> motions;  // one a body, then one a copy (split_system.h); likewise these two
  std::span<SpeedChange<T>> begun;     // velocities and spins when the substep began
  std::span<ScaledInverseInertia<T>> scaled_inverse_inertias;
  std::size_t known = 0;   // bodies of the last step in this precision
  bool used_last = false;  // by the last step: motions and what is beside them know what rests

  std::span<PointLanes<T>> manifold_points_of(const ContactBlock& block) {
    return std::span(manifold_points).subspan(block.first, block.manifold_points);
  }
  std::span<TotalLanes<T>> totals_of(const ContactBlock& block) {
    return std::span(totals).subspan(block.first, block.manifold_points);
  }
  BodyLanes<T> bodies() { return {motions.data(), scaled_inverse_inertias.data()}; }
};

/// The inverse inertia of a body as the lanes need it.
template <class T>
ScaledInverseInertia<T> scaled_inverse_inertia(const SolverBody& body, const Mat3& inverse_inertia);

/// The substeps of a step.
struct SubstepTimes {
  double substep_s = 0;
  double late_s = 0;     ///< by which the last substep begins later than the step
  double still_mps = 0;  ///< what moves against each other more slowly does not slide
};

/// Fills a block, whose `begin`, `count`, `manifold_points` and `first` are set, and its lanes from its pairs.
template <class T>
void fill_block(const SplitSystem& system, const BlockTerms& terms, ContactBlock& block, PairLanes<T>& shared,
                Lanes<T>& lanes);

/// Adds the impulses of a substep to the totals of the step; those of the first substep are the first.
template <class T>
void add_totals(const ContactBlock& block, bool first, Lanes<T>& lanes);

/// Applies the total impulses of the step to the bodies of a block, in double precision and at one point for both
/// bodies, and stores the forces of the last substep, which warm start the next step. Completes the shifts of pairs
/// that slide, and notes them in `block`.
template <class T>
void write_back_block(const SplitSystem& system, const SubstepTimes& times, ContactBlock& block, PairLanes<T>& shared,
                      std::span<const PointLanes<T>> manifold_points, std::span<const TotalLanes<T>> totals);

extern template ScaledInverseInertia<float> scaled_inverse_inertia(const SolverBody&, const Mat3&);
extern template ScaledInverseInertia<double> scaled_inverse_inertia(const SolverBody&, const Mat3&);
extern template void fill_block(const SplitSystem&, const BlockTerms&, ContactBlock&, PairLanes<float>&, Lanes<float>&);
extern template void fill_block(const SplitSystem&, const BlockTerms&, ContactBlock&, PairLanes<double>&,
                                Lanes<double>&);
extern template void add_totals(const ContactBlock&, bool, Lanes<float>&);
extern template void add_totals(const ContactBlock&, bool, Lanes<double>&);
extern template void write_back_block(const SplitSystem&, const SubstepTimes&, ContactBlock&, PairLanes<float>&,
                                      std::span<const PointLanes<float>>, std::span<const TotalLanes<float>>);
extern template void write_back_block(const SplitSystem&, const SubstepTimes&, ContactBlock&, PairLanes<double>&,
                                      std::span<const PointLanes<double>>, std::span<const TotalLanes<double>>);

}  // namespace poise::solver
