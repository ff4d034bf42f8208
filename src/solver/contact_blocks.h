// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "parallel/large_pages.h"
#include "solver/contact_lanes.h"
#include "solver/contact_solver.h"

namespace poise::solver {

// Lanes and motions in one precision.
template <class T>
struct Lanes {
  parallel::LargeVector<PairLanes<T>> pairs;  // one a block
  parallel::LargeVector<PointLanes<T>> manifold_points;
  parallel::LargeVector<Motion<T>> motions;                     // one a body
  parallel::LargeVector<Motion<T>> begun;                       // velocities and spins when the substep began
  parallel::LargeVector<AngularResponse<T>> angular_responses;  // one a body

  std::span<PointLanes<T>> manifold_points_of(const RestBlock& block) {
    return std::span(manifold_points).subspan(block.first, block.manifold_points);
  }
  BodyLanes<T> bodies() { return {motions.data(), angular_responses.data()}; }
};

/// How a body turns, for lanes.
template <class T>
AngularResponse<T> angular_response(const SolverBody& body, const Mat3& inverse_inertia);

/// Makes a block, of which `begin`, `count`, `patches` and `first` are known, and its lanes from its pairs.
template <class T>
void fill_block(const ContactSystem& system, double still_mps, RestBlock& block, PairLanes<T>& shared, Lanes<T>& lanes);

/// Asks for what fill_block and give_block will read of a block's pairs, some blocks before it is their turn: pairs of
/// a colour lie far apart.
void fetch_pairs(const ContactSystem& system, const RestBlock& block);
void fetch_points(const ContactSystem& system, const RestBlock& block);
void fetch_loads(const ContactSystem& system, const RestBlock& block);

/// Adds what a substep came to, to what the step came to.
template <class T>
void add_totals(const RestBlock& block, Lanes<T>& lanes);

/// Gives the bodies of a block what its places came to in the step, in double precision and at one point for both
/// bodies of each, and the places what the next step starts with.
template <class T>
void give_block(const ContactSystem& system, const RestBlock& block, const PairLanes<T>& shared, Lanes<T>& lanes);

extern template AngularResponse<float> angular_response(const SolverBody&, const Mat3&);
extern template AngularResponse<double> angular_response(const SolverBody&, const Mat3&);
extern template void fill_block(const ContactSystem&, double, RestBlock&, PairLanes<float>&, Lanes<float>&);
extern template void fill_block(const ContactSystem&, double, RestBlock&, PairLanes<double>&, Lanes<double>&);
extern template void add_totals(const RestBlock&, Lanes<float>&);
extern template void add_totals(const RestBlock&, Lanes<double>&);
extern template void give_block(const ContactSystem&, const RestBlock&, const PairLanes<float>&, Lanes<float>&);
extern template void give_block(const ContactSystem&, const RestBlock&, const PairLanes<double>&, Lanes<double>&);

}  // namespace poise::solver
