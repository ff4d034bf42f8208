// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include "collision/front/front.h"
#include "collision/front/pair_frame.h"

namespace poise::collision {

/// The contacts of a run of entries of two trees as a structure of arrays, and their terms of a wrench; in the frame of
/// a.
struct ContactBatch {
  static constexpr std::size_t kEntries = 32;
  using Figures = double[kEntries];
  struct alignas(64) Vectors {
    Figures x, y, z;
  };
  Vectors normal, point_m;  ///< as in SphereContact
  alignas(64) Figures gap_m;
  alignas(64) Figures expected_m;          ///< sum of the mean protrusions of both nodes
  alignas(64) Figures certain_m;           ///< sum of the largest
  alignas(64) Figures weight_m;            ///< w, 0 where the gap is no smaller than the limit
  Vectors direction, moment_m2, place_m2;  ///< w n, c x w n, w c
  std::size_t count = 0;  ///< entries; array elements up to the next multiple of eight repeat the last one
};

/// Sets normals, points, gaps and protrusions: what sphere_contact says of each entry, bit for bit on any instruction
/// set. For two trees, not a plane, and for 1 to ContactBatch::kEntries entries.
void set_contacts(const PairFrame& frame, std::span<const FrontEntry> entries, ContactBatch& batch);

/// Sets the rest from them: w = limit_m - gap for the contacts with gap < limit_m and gap < margin_m.
void set_wrenches(double limit_m, double margin_m, ContactBatch& batch);

}  // namespace poise::collision
