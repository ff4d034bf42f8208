// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/front/overlap_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "collision/front/overlap_kernel.h"

#ifndef POISE_OVERLAP_KERNEL_ONCE
#define POISE_OVERLAP_KERNEL_ONCE
namespace poise::collision {

// Of each of the 256 rows of eight bits, the places of those that are set, and zeros.
struct SetPlaces {
  alignas(64) std::uint32_t of_row[1U << kTreeBranching][kTreeBranching]{};
  constexpr SetPlaces() {
    for (std::uint32_t row = 0; row < 1U << kTreeBranching; ++row) {
      std::size_t count = 0;
      for (std::uint32_t place = 0; place < kTreeBranching; ++place) {
        if ((row >> place & 1U) != 0) of_row[row][count++] = place;
      }
    }
  }
};
inline constexpr SetPlaces kColumns;

// Bits of the pairs of the first rows, and of the first columns, of spheres of a block.
struct FirstBits {
  std::uint64_t of_rows[kTreeBranching + 1]{}, of_columns[kTreeBranching + 1]{};
  constexpr FirstBits() {
    for (std::uint32_t bit = 0; bit < kTreeBranching * kTreeBranching; ++bit) {
      for (std::uint32_t rows = bit / kTreeBranching + 1; rows <= kTreeBranching; ++rows)
        of_rows[rows] |= std::uint64_t{1} << bit;
      for (std::uint32_t columns = bit % kTreeBranching + 1; columns <= kTreeBranching; ++columns)
        of_columns[columns] |= std::uint64_t{1} << bit;
    }
  }
};
inline constexpr FirstBits kFirst;

}  // namespace poise::collision
#endif

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Multiplications and additions stay apart: fused ones would round differently from one instruction set to the next.

// The arrays of a tree that a test reads.
struct Spheres {
  const float* x;
  const float* y;
  const float* z;
  const float* radius;
  explicit Spheres(const SphereTree& tree)
      : x(tree.x_m.data()), y(tree.y_m.data()), z(tree.z_m.data()), radius(tree.radius_m.data()) {}
};

// Bit 8 i + j is set when sphere first_a + i of a comes as near to sphere first_b + j of b as each limit says.
struct Near {
  std::uint64_t bits, close, wide;
};

// Of each sphere of b the sphere of a that is nearest, and how near.
struct Nearest {
  alignas(32) float square_m2[kTreeBranching];  // |o_a - o_b|^2 - (r_a + r_b)^2
  alignas(32) float row[kTreeBranching];
};

// What an expansion does beside the tests of the front itself.
struct Lists {
  bool front = true;     // the list of what overlaps; otherwise it is only counted
  bool close = false;    // a second list of what is close
  bool nearest = false;  // a list of the nearest children of each entry
  bool wide = false;     // nodes that nearly overlap are told
};

template <Lists kLists>
HWY_INLINE Near overlaps(const Spheres& a, NodeIndex first_a, std::uint32_t rows, const Spheres& b, NodeIndex first_b,
                         const FloatFrame& frame, const Nearness& nearness, float closeness,
                         [[maybe_unused]] Nearest& nearest) {
  const hn::CappedTag<float, kTreeBranching> d;
  const auto at = [&](int i) HWY_ATTR { return hn::Set(d, frame.rotation[i]); };
  Near found{0, 0, 0};
  for (std::size_t j = 0; j < kTreeBranching; j += hn::Lanes(d)) {
    const auto x = hn::LoadU(d, b.x + first_b + j);
    const auto y = hn::LoadU(d, b.y + first_b + j);
    const auto z = hn::LoadU(d, b.z + first_b + j);
    const auto row = [&](int r) HWY_ATTR {
      return hn::Add(hn::Add(hn::Mul(at(r), x), hn::Mul(at(r + 1), y)),
                     hn::Add(hn::Mul(at(r + 2), z), hn::Set(d, frame.offset_m[r / 3])));
    };
    const auto moved_x = row(0);
    const auto moved_y = row(3);
    const auto moved_z = row(6);
    const auto radius = hn::LoadU(d, b.radius + first_b + j);
    const auto inflated = hn::Add(radius, hn::Set(d, nearness.inflation_m));
    [[maybe_unused]] const auto wide = hn::Set(d, nearness.wide_m);
    [[maybe_unused]] const auto closer = hn::Add(radius, hn::Set(d, closeness));
    [[maybe_unused]] auto least = hn::Set(d, std::numeric_limits<float>::max());
    [[maybe_unused]] auto row_of_least = hn::Zero(d);
    for (std::size_t i = 0; i < rows; ++i) {
      const auto dx = hn::Sub(moved_x, hn::Set(d, a.x[first_a + i]));
      const auto dy = hn::Sub(moved_y, hn::Set(d, a.y[first_a + i]));
      const auto dz = hn::Sub(moved_z, hn::Set(d, a.z[first_a + i]));
      const auto reach = hn::Add(inflated, hn::Set(d, a.radius[first_a + i]));
      const auto square = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      const auto bits_of = [&](auto limit) HWY_ATTR {
        std::uint8_t stored[8] = {};
        hn::StoreMaskBits(d, hn::Lt(square, hn::Mul(limit, limit)), stored);
        return std::uint64_t{stored[0]} << (kTreeBranching * i + j);
      };
      found.bits |= bits_of(reach);
      if constexpr (kLists.wide) found.wide |= bits_of(hn::Add(reach, wide));
      if constexpr (kLists.close) {
        const auto near = hn::Add(closer, hn::Set(d, a.radius[first_a + i]));
        found.close |= bits_of(hn::Max(near, hn::Zero(d)));
      }
      if constexpr (kLists.nearest) {
        const auto both = hn::Add(radius, hn::Set(d, a.radius[first_a + i]));
        const auto beyond = hn::Sub(square, hn::Mul(both, both));
        const auto nearer = hn::Lt(beyond, least);
        least = hn::IfThenElse(nearer, beyond, least);
        row_of_least = hn::IfThenElse(nearer, hn::Set(d, static_cast<float>(i)), row_of_least);
      }
    }
    if constexpr (kLists.nearest) {
      hn::Store(least, d, nearest.square_m2 + j);
      hn::Store(row_of_least, d, nearest.row + j);
    }
  }
  return found;
}

// The entries whose own nodes overlap, in order; how many.
std::uint32_t narrow(const TreePair& trees, float inflation_m, std::span<const FrontEntry> front,
                     std::span<FrontEntry> out) {
  const hn::CappedTag<float, kTreeBranching> d;
  const Spheres spheres_a(trees.a);
  const Spheres spheres_b(trees.b);
  const FloatFrame& frame = trees.frame;
  std::uint32_t kept = 0;
  alignas(32) float of_a[4][kTreeBranching];
  alignas(32) float of_b[4][kTreeBranching];
  alignas(32) float apart[kTreeBranching];
  for (std::size_t first = 0; first < front.size(); first += kTreeBranching) {
    const std::size_t count = std::min<std::size_t>(kTreeBranching, front.size() - first);
    for (std::size_t k = 0; k < kTreeBranching; ++k) {
      const FrontEntry entry = front[first + std::min(k, count - 1)];
      of_a[0][k] = spheres_a.x[entry.a];
      of_a[1][k] = spheres_a.y[entry.a];
      of_a[2][k] = spheres_a.z[entry.a];
      of_a[3][k] = spheres_a.radius[entry.a];
      of_b[0][k] = spheres_b.x[entry.b];
      of_b[1][k] = spheres_b.y[entry.b];
      of_b[2][k] = spheres_b.z[entry.b];
      of_b[3][k] = spheres_b.radius[entry.b];
    }
    for (std::size_t k = 0; k < kTreeBranching; k += hn::Lanes(d)) {
      const auto x = hn::Load(d, of_b[0] + k);
      const auto y = hn::Load(d, of_b[1] + k);
      const auto z = hn::Load(d, of_b[2] + k);
      const auto difference = [&](std::size_t row) HWY_ATTR {
        const float* const turn = frame.rotation + 3 * row;
        const auto moved = hn::Add(hn::Add(hn::Mul(hn::Set(d, turn[0]), x), hn::Mul(hn::Set(d, turn[1]), y)),
                                   hn::Add(hn::Mul(hn::Set(d, turn[2]), z), hn::Set(d, frame.offset_m[row])));
        return hn::Sub(moved, hn::Load(d, of_a[row] + k));
      };
      const auto dx = difference(0);
      const auto dy = difference(1);
      const auto dz = difference(2);
      const auto square = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      const auto reach = hn::Add(hn::Add(hn::Load(d, of_b[3] + k), hn::Set(d, inflation_m)), hn::Load(d, of_a[3] + k));
      hn::Store(hn::Sub(square, hn::Mul(reach, reach)), d, apart + k);
    }
    for (std::size_t k = 0; k < count; ++k) {
      out[kept] = front[first + k];
      kept += apart[k] < 0 ? 1U : 0U;
    }
  }
  return kept;
}

// The pairs of an entry's children that overlap, as bits. Not set to zero before they are known: that takes longer than
// the tests of a few entries.
struct Block {
  Near found;
  NodeIndex first_a, first_b;
  std::uint32_t columns;
  [[nodiscard]] FrontEntry first() const { return {first_a, first_b}; }
};

// The nearest children of a block: of several that are, those in the first column.
HWY_INLINE FrontEntry nearest_of(const Nearest& nearest, const Block& block) {
  const hn::CappedTag<float, kTreeBranching> d;
  std::uint32_t column = 0;
  if constexpr (hn::MaxLanes(d) == kTreeBranching) {
    const auto square = hn::IfThenElse(hn::FirstN(d, block.columns), hn::Load(d, nearest.square_m2),
                                       hn::Set(d, std::numeric_limits<float>::max()));
    const auto least = hn::FindFirstTrue(d, hn::Eq(square, hn::MinOfLanes(d, square)));
    column = static_cast<std::uint32_t>(least);
  } else {
    for (std::uint32_t j = 1; j < block.columns; ++j) {
      if (nearest.square_m2[j] < nearest.square_m2[column]) column = j;
    }
  }
  return {block.first_a + static_cast<NodeIndex>(nearest.row[column]), block.first_b + column};
}

// Writes the pairs of a block in order, one by one: at most kMost; entries of `out` beyond them may be
// overwritten.
template <int kMost>
HWY_INLINE void list_few(std::uint64_t bits, FrontEntry first, FrontEntry* out) {
  for (int k = 0; k < kMost; ++k) {
    const auto place = static_cast<std::uint32_t>(std::countr_zero(bits));
    *out++ = {first.a + place / kTreeBranching, first.b + place % kTreeBranching};
    bits &= bits - 1;
  }
}

// Writes the pairs of a block in order; entries of `out` beyond them may be overwritten, but none beyond the block's
// own 64.
#if HWY_TARGET == HWY_SCALAR
std::uint32_t list_hits(std::uint64_t bits, FrontEntry first, FrontEntry* out) {
  const auto hits = static_cast<std::uint32_t>(std::popcount(bits));
  for (; bits != 0; bits &= bits - 1) list_few<1>(bits, first, out++);
  return hits;
}
#else
// Few one by one; else row by row, each as if all of its eight were there: how many there are no processor foresees.
HWY_INLINE std::uint32_t list_hits(std::uint64_t bits, FrontEntry first, FrontEntry* out) {
  static_assert(std::endian::native == std::endian::little && sizeof(FrontEntry) == sizeof(std::uint64_t));
  constexpr int kFew = 4;     // most blocks of two jacks have no more
  constexpr int kAtOnce = 4;  // most blocks have no more rows, and then the loop ends as foreseen
  const hn::CappedTag<std::uint64_t, kTreeBranching> d;
  const hn::Rebind<std::uint32_t, decltype(d)> narrow;
  const auto hits = static_cast<std::uint32_t>(std::popcount(bits));
  if (hits <= kFew) {
    list_few<kFew>(bits, first, out);
    return hits;
  }
  while (bits != 0) {
    // A row that is not there any more has no places, and is written where a later one, or nothing, comes.
    for (int k = 0; k < kAtOnce; ++k) {
      const auto from = static_cast<std::uint32_t>(std::countr_zero(bits)) & 56U;
      const std::uint64_t row = bits >> from & 0xffU;
      bits &= ~(std::uint64_t{0xff} << from);
      const auto start = hn::Set(d, (std::uint64_t{first.b} << 32U) + first.a + from / kTreeBranching);
      for (std::size_t j = 0; j < kTreeBranching; j += hn::Lanes(d)) {
        const auto columns = hn::PromoteTo(d, hn::Load(narrow, kColumns.of_row[row] + j));
        hn::StoreU(hn::Add(start, hn::ShiftLeft<32>(columns)), d, reinterpret_cast<std::uint64_t*>(out) + j);
      }
      out += std::popcount(row);
    }
  }
  return hits;
}
#endif

template <Lists kLists>
HWY_INLINE Expansion expand_blocks(const TreePair& trees, const Nearness& nearness, float closeness,
                                   std::span<const FrontEntry> front, const ExpansionLists& lists) {
  // Tests of many entries first, then their lists: tests without a branch run into each other, while a list's length,
  // which no processor foresees, holds up what comes after it.
  constexpr std::size_t kBlocks = 32;
  constexpr std::size_t kPairs = std::size_t{kTreeBranching} * kTreeBranching;
  const Spheres spheres_a(trees.a);
  const Spheres spheres_b(trees.b);
  const NodeIndex* const children_a = trees.a.first_child.data();
  const NodeIndex* const children_b = trees.b.first_child.data();
  const std::uint8_t* const counts_a = trees.a.child_count.data();
  const std::uint8_t* const counts_b = trees.b.child_count.data();
  const FloatFrame moved = trees.frame;
  std::array<Block, kBlocks> blocks;  // NOLINT(cppcoreguidelines-pro-type-member-init): see Block
  std::array<Nearest, kLists.nearest ? kBlocks : 1> nearest;
  Expansion result;
  while (result.consumed < front.size()) {
    const std::size_t count = std::min(kBlocks, front.size() - result.consumed);
    for (std::size_t k = 0; k < count; ++k) {
      const FrontEntry entry = front[result.consumed + k];
      const FrontEntry first{children_a[entry.a], children_b[entry.b]};
      const std::uint32_t rows = std::max<std::uint32_t>(counts_a[entry.a], 1);
      const std::uint32_t columns = std::max<std::uint32_t>(counts_b[entry.b], 1);
      const std::uint64_t used = kFirst.of_rows[rows] & kFirst.of_columns[columns];
      const Near found = overlaps<kLists>(spheres_a, first.a, rows, spheres_b, first.b, moved, nearness, closeness,
                                          nearest[kLists.nearest ? k : 0]);
      blocks[k] = {{used & found.bits, used & found.close, used & found.wide}, first.a, first.b, columns};
    }
    for (std::size_t k = 0; k < count; ++k) {
      const Block& block = blocks[k];
      if constexpr (kLists.wide) result.nearly = result.nearly || block.found.wide != block.found.bits;
      if constexpr (kLists.front) {
        if (lists.front.size() - result.hits < kPairs) return result;
        result.hits += list_hits(block.found.bits, block.first(), lists.front.data() + result.hits);
      } else {
        result.hits += static_cast<std::uint32_t>(std::popcount(block.found.bits));
      }
      if constexpr (kLists.close) {
        if (lists.close.size() - result.close < kPairs) return result;
        result.close += list_hits(block.found.close, block.first(), lists.close.data() + result.close);
      }
      if constexpr (kLists.nearest) {
        lists.nearest[result.nearest] = nearest_of(nearest[k], block);
        result.nearest += block.found.bits != 0 ? 1U : 0U;
      }
      ++result.consumed;
    }
  }
  return result;
}

Expansion expand(const TreePair& trees, const Nearness& nearness, std::span<const FrontEntry> front,
                 std::span<FrontEntry> out) {
  return expand_blocks<Lists{.wide = true}>(trees, nearness, 0, front, {out, {}, {}});
}

template <Lists kLists>
Expansion expand_wide(const TreePair& trees, const Nearness& nearness, float closeness,
                      std::span<const FrontEntry> front, const ExpansionLists& lists) {
  constexpr Lists kWide{kLists.front, kLists.close, kLists.nearest, true};
  return nearness.wide_m > 0 ? expand_blocks<kWide>(trees, nearness, closeness, front, lists)
                             : expand_blocks<kLists>(trees, nearness, closeness, front, lists);
}

Expansion expand_lists(const TreePair& trees, const Nearness& nearness, float closeness,
                       std::span<const FrontEntry> front, const ExpansionLists& lists) {
  if (lists.nearest.empty()) return expand_wide<Lists{.close = true}>(trees, nearness, closeness, front, lists);
  if (lists.counts_front)
    return expand_wide<Lists{.front = false, .close = true, .nearest = true}>(trees, nearness, closeness, front, lists);
  return expand_wide<Lists{.close = true, .nearest = true}>(trees, nearness, closeness, front, lists);
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {

HWY_EXPORT(expand);
HWY_EXPORT(expand_lists);
HWY_EXPORT(narrow);

Expansion expand_front(const TreePair& trees, const Nearness& nearness, std::span<const FrontEntry> front,
                       std::span<FrontEntry> out) {
  return HWY_DYNAMIC_DISPATCH(expand)(trees, nearness, front, out);
}

Expansion expand_front(const TreePair& trees, const Nearness& nearness, float closeness_m,
                       std::span<const FrontEntry> front, const ExpansionLists& lists) {
  return HWY_DYNAMIC_DISPATCH(expand_lists)(trees, nearness, closeness_m, front, lists);
}

std::uint32_t narrow_front(const TreePair& trees, float inflation_m, std::span<const FrontEntry> front,
                           std::span<FrontEntry> out) {
  return HWY_DYNAMIC_DISPATCH(narrow)(trees, inflation_m, front, out);
}

Expansion expand_plane_front(const SphereTree& a, const float (&normal)[3], float offset_m, const Nearness& nearness,
                             std::span<const FrontEntry> front, std::span<FrontEntry> out) {
  Expansion result;
  for (const FrontEntry entry : front) {
    if (out.size() - result.hits < kTreeBranching) return result;
    const NodeIndex first = a.first_child[entry.a];
    const std::uint32_t count = a.child_count[entry.a] == 0 ? 1U : a.child_count[entry.a];
    for (NodeIndex node = first; node < first + count; ++node) {
      const float height = normal[0] * a.x_m[node] + normal[1] * a.y_m[node] + normal[2] * a.z_m[node] - offset_m;
      const float reach = a.radius_m[node] + nearness.inflation_m;
      if (height < reach) {
        out[result.hits++] = {node, 0};
      } else if (height < reach + nearness.wide_m) {
        result.nearly = true;
      }
    }
    ++result.consumed;
  }
  return result;
}

}  // namespace poise::collision
#endif
