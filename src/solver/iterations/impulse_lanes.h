// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include "solver/contacts/contact_lanes.h"

/// The impulses of a block as numbers one after another, for what treats all of them alike: contact point by contact
/// point, and of each lane in use that along the normal and, where a pair of the block has friction, the three across
/// it. All of this is done several lanes at a time, with the bits of one lane after another.
namespace poise::solver {

/// How many numbers a contact point of a block has.
[[nodiscard]] inline std::size_t numbers_of_point(const ContactBlock& block) {
  return std::size_t{block.count} * (block.frictional ? 4U : 1U);
}
/// How many the whole block has.
[[nodiscard]] inline std::size_t impulse_numbers(const ContactBlock& block) {
  return block.manifold_points * numbers_of_point(block);
}
/// Numbers that may be read, and are not used, beyond those of a block.
inline constexpr std::size_t kNumbersBeyond = 4 * kLanes;

/// The impulses, each times its root. `roots` as AndersonMixing's numbers; kNumbersBeyond more must be readable.
void list_impulses(const ContactBlock& block, std::span<const PointLanes<double>> manifold_points, const double* roots,
                   double* into);

/// Makes impulses of numbers that were extrapolated: divided by their roots, pressing, across the normal, within the
/// friction cone. `wanted` is read and then holds these impulses, `before` those that the block has, and the lanes the
/// change, which warm_start_block gives to the bodies. kNumbersBeyond more must be readable.
void change_impulses(const ContactBlock& block, const PairLanes<double>& pairs,
                     std::span<PointLanes<double>> manifold_points, const double* roots, double* wanted,
                     double* before);

/// Sets the impulses of the lanes in use, and lists them as list_impulses would. kNumbersBeyond more must be readable.
void set_impulses(const ContactBlock& block, std::span<PointLanes<double>> manifold_points, const double* impulses,
                  const double* roots, double* into);

}  // namespace poise::solver
