// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "poise/mesh.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {

/// What decides a built tree, as 128 bits (XXH3 of Collet's xxHash).
using TreeKey = std::array<std::uint8_t, 16>;

/// Largest entry there can be: a full tree of kMaxTreeDepth.
extern const std::uint64_t kMostEntryBytes;

TreeKey tree_key(const TriangleMesh& mesh, const TreeBuildOptions& options);
/// 32 hexadecimal digits.
std::string key_text(const TreeKey& key);

/// An entry: head (magic word, byte order, versions, sizes, key), the arrays without their padding, checksum of all
/// that.
std::string entry_bytes(const SphereTree& tree, const TreeKey& key);

/// The tree of an entry; none if the bytes are not exactly an entry of this version and key whose every count, index
/// and number keeps the rules of SphereTree. A matching checksum is not taken for a proof of that.
std::optional<SphereTree> entry_tree(std::string_view bytes, const TreeKey& key);

}  // namespace poise::geometry
