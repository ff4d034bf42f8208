// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "solver/contacts/contact_blocks.h"

/// Returns the angular momentum that contacts took or added by moving bodies otherwise than with their final velocity.
///
/// An impulse acts at one point of both bodies, so it keeps the angular momentum where they stand. But a body that is
/// moved by d beyond its velocity v changes it by m d x v. Contacts move pairs so in two ways: position correction, and
/// impulses of the second and later substeps, which give the velocity of the whole step but act from their substep on.
/// Both move the bodies of a pair by P / m in opposite directions, so a pair changes the sum by P x (v_b - v_a).
namespace poise::solver {

/// Adds to the shifts of a block what the impulses of a substep that began `late_s` after the step move less than their
/// velocities say, m. For all substeps but the first and the last; write_back_block does it for the last.
template <class T>
void add_late_impulses(const ContactBlock& block, double late_s, PairLanes<T>& shared,
                       std::span<const PointLanes<T>> manifold_points);

/// The last two phases of a step, once all velocities are final, for blocks with ContactBlock::shifted. The first
/// replaces the shift of each such pair by the angular momentum that it added, N m s divided by the reduced mass; the
/// second takes it from the two bodies as if they were one rigid body, so that their speeds at the contact against each
/// other stay. Where that would add energy, what moves them against that rigid body is reduced as much; where even that
/// is not enough, the pair is left as it is. The first reads bodies alone; the second changes them, so that blocks of a
/// colour come one after another.
template <class T>
void measure_angular_change(const SplitSystem& system, const ContactBlock& block, PairLanes<T>& shared);
template <class T>
void return_angular_momentum(const SplitSystem& system, const ContactBlock& block, const PairLanes<T>& shared);

extern template void add_late_impulses(const ContactBlock&, double, PairLanes<float>&,
                                       std::span<const PointLanes<float>>);
extern template void add_late_impulses(const ContactBlock&, double, PairLanes<double>&,
                                       std::span<const PointLanes<double>>);
extern template void measure_angular_change(const SplitSystem&, const ContactBlock&, PairLanes<float>&);
extern template void measure_angular_change(const SplitSystem&, const ContactBlock&, PairLanes<double>&);
extern template void return_angular_momentum(const SplitSystem&, const ContactBlock&, const PairLanes<float>&);
extern template void return_angular_momentum(const SplitSystem&, const ContactBlock&, const PairLanes<double>&);

}  // namespace poise::solver
