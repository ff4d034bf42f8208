// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "collision/front/front.h"
#include "poise/sphere_tree.h"

namespace poise::collision {

/// The frame of b in the frame of a, single precision: p_a = rotation * p_b + offset, rotation by rows.
struct FloatFrame {
  float rotation[9];
  float offset_m[3];
};

/// Distances added to the sum of the two radii, metres.
struct Nearness {
  float inflation_m = 0;  ///< covers the rounding of single precision
  float wide_m = 0;       ///< >= 0: nodes that miss each other by less count as nearly overlapping
};

/// Two trees, and where b is in the frame of a.
struct TreePair {
  const SphereTree& a;
  const SphereTree& b;
  const FloatFrame& frame;
};

/// Result of an expansion.
struct Expansion {
  std::uint32_t consumed = 0;  ///< entries of the input that were expanded; fewer than given when a list was full
  std::uint32_t hits = 0;      ///< overlapping pairs of children: entries of the new front
  std::uint32_t close = 0;     ///< entries of the second list
  std::uint32_t nearest = 0;   ///< entries of the third
  bool nearly = false;         ///< some two nodes that do not overlap would overlap with wide_m more
};

/// Where an expansion lists what it finds, each in order.
struct ExpansionLists {
  std::span<FrontEntry> front;    ///< all that overlap: kTreeBranching^2 free entries for each block
  std::span<FrontEntry> close;    ///< those of them with |o_a - o_b| < r_a + r_b + closeness_m: likewise
  std::span<FrontEntry> nearest;  ///< of each expanded entry with any, the children with the least
                                  ///< |o_a - o_b|^2 - (r_a + r_b)^2: an entry each; empty: none are listed
  bool counts_front = false;      ///< where the nearest are listed: what overlaps is only counted
};

/// Expands each entry of a front into the overlapping pairs of its nodes' children (a leaf stands for itself), in
/// order. Two nodes overlap when |o_a - o_b| < r_a + r_b + inflation_m. Needs kTreeBranching^2 free entries for each
/// block. Any instruction set gives the same bits.
Expansion expand_front(const TreePair& trees, const Nearness& nearness, std::span<const FrontEntry> front,
                       std::span<FrontEntry> out);

/// The same with more lists.
Expansion expand_front(const TreePair& trees, const Nearness& nearness, float closeness_m,
                       std::span<const FrontEntry> front, const ExpansionLists& lists);

/// The entries whose two nodes overlap themselves, |o_a - o_b| < r_a + r_b + inflation_m, in order: what is left of a
/// front that was searched farther. `out` has room for all. How many. Any instruction set gives the same bits.
std::uint32_t narrow_front(const TreePair& trees, float inflation_m, std::span<const FrontEntry> front,
                           std::span<FrontEntry> out);

/// An expansion against the half-space normal . p <= offset, given in the frame of a: nodes with
/// normal . o - offset < r + inflation_m. The b of each entry stays 0.
Expansion expand_plane_front(const SphereTree& a, const float (&normal)[3], float offset_m, const Nearness& nearness,
                             std::span<const FrontEntry> front, std::span<FrontEntry> out);

}  // namespace poise::collision
