// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/overlap_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <bit>

#include "collision/overlap_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Eight spheres of b in the frame of a. Multiplications and additions stay apart: fused ones would round differently
// from one instruction set to the next.
struct Block {
  alignas(64) float x[kTreeBranching], y[kTreeBranching], z[kTreeBranching], reach[kTreeBranching];
};

void move_block(const SphereTree& b, NodeIndex first, const FloatFrame& frame, float inflation, Block& block) {
  const hn::CappedTag<float, kTreeBranching> d;
  const auto at = [&](int i) { return hn::Set(d, frame.rotation[i]); };
  for (std::size_t i = 0; i < kTreeBranching; i += hn::Lanes(d)) {
    const auto x = hn::LoadU(d, b.x_m.data() + first + i);
    const auto y = hn::LoadU(d, b.y_m.data() + first + i);
    const auto z = hn::LoadU(d, b.z_m.data() + first + i);
    const auto row = [&](int r) {
      return hn::Add(hn::Add(hn::Mul(at(r), x), hn::Mul(at(r + 1), y)),
                     hn::Add(hn::Mul(at(r + 2), z), hn::Set(d, frame.offset_m[r / 3])));
    };
    hn::Store(row(0), d, block.x + i);
    hn::Store(row(3), d, block.y + i);
    hn::Store(row(6), d, block.z + i);
    hn::Store(hn::Add(hn::LoadU(d, b.radius_m.data() + first + i), hn::Set(d, inflation)), d, block.reach + i);
  }
}

// Bit j is set when sphere j of the block overlaps the sphere of a.
std::uint32_t overlaps(const Block& block, float x, float y, float z, float radius) {
  const hn::CappedTag<float, kTreeBranching> d;
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < kTreeBranching; i += hn::Lanes(d)) {
    const auto dx = hn::Sub(hn::Load(d, block.x + i), hn::Set(d, x));
    const auto dy = hn::Sub(hn::Load(d, block.y + i), hn::Set(d, y));
    const auto dz = hn::Sub(hn::Load(d, block.z + i), hn::Set(d, z));
    const auto reach = hn::Add(hn::Load(d, block.reach + i), hn::Set(d, radius));
    const auto square = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
    std::uint8_t stored[8] = {};
    hn::StoreMaskBits(d, hn::Lt(square, hn::Mul(reach, reach)), stored);
    bits |= static_cast<std::uint32_t>(stored[0]) << i;
  }
  return bits;
}

Expansion expand(const SphereTree& a, const SphereTree& b, const FloatFrame& frame, float inflation,
                 std::span<const FrontEntry> front, std::span<FrontEntry> out) {
  Block block;
  NodeIndex moved = ~NodeIndex{0};
  Expansion result;
  for (const FrontEntry entry : front) {
    if (out.size() - result.hits < std::size_t{kTreeBranching} * kTreeBranching) return result;
    const NodeIndex first_a = a.first_child[entry.a];
    const NodeIndex first_b = b.first_child[entry.b];
    const std::uint32_t count_a = a.child_count[entry.a] == 0 ? 1U : a.child_count[entry.a];
    const std::uint32_t count_b = b.child_count[entry.b] == 0 ? 1U : b.child_count[entry.b];
    const std::uint32_t used = (1U << count_b) - 1U;
    if (first_b != moved) {
      move_block(b, first_b, frame, inflation, block);
      moved = first_b;
    }
    for (std::uint32_t i = 0; i < count_a; ++i) {
      const NodeIndex node = first_a + i;
      std::uint32_t bits = used & overlaps(block, a.x_m[node], a.y_m[node], a.z_m[node], a.radius_m[node]);
      for (; bits != 0; bits &= bits - 1) {
        out[result.hits++] = {node, first_b + static_cast<NodeIndex>(std::countr_zero(bits))};
      }
    }
    ++result.consumed;
  }
  return result;
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {

HWY_EXPORT(expand);

Expansion expand_front(const SphereTree& a, const SphereTree& b, const FloatFrame& frame, float inflation_m,
                       std::span<const FrontEntry> front, std::span<FrontEntry> out) {
  return HWY_DYNAMIC_DISPATCH(expand)(a, b, frame, inflation_m, front, out);
}

Expansion expand_plane_front(const SphereTree& a, const float (&normal)[3], float offset_m, float inflation_m,
                             std::span<const FrontEntry> front, std::span<FrontEntry> out) {
  Expansion result;
  for (const FrontEntry entry : front) {
    if (out.size() - result.hits < kTreeBranching) return result;
    const NodeIndex first = a.first_child[entry.a];
    const std::uint32_t count = a.child_count[entry.a] == 0 ? 1U : a.child_count[entry.a];
    for (NodeIndex node = first; node < first + count; ++node) {
      const float height = normal[0] * a.x_m[node] + normal[1] * a.y_m[node] + normal[2] * a.z_m[node] - offset_m;
      if (height < a.radius_m[node] + inflation_m) out[result.hits++] = {node, 0};
    }
    ++result.consumed;
  }
  return result;
}

}  // namespace poise::collision
#endif
