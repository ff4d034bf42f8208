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

/// Hash of everything that determines a built tree, 128 bits (XXH3 of Collet's xxHash).
using TreeKey = std::array<std::uint8_t, 16>;

/// Size of the largest possible entry: a full tree of kMaxTreeDepth.
extern const std::uint64_t kMostEntryBytes;

TreeKey tree_key(const TriangleMesh& mesh, const TreeBuildOptions& options);
/// The key as 32 hexadecimal digits.
std::string key_text(const TreeKey& key);

/// The bytes of an entry: head (magic word, byte order, versions, sizes, key), the arrays without their padding, and a
/// checksum of both.
std::string entry_bytes(const SphereTree& tree, const TreeKey& key);

/// The tree of an entry; empty unless the bytes are exactly an entry of this version and key, and every count, index
/// and number is valid for SphereTree. These are checked even if the checksum matches.
std::optional<SphereTree> entry_tree(std::string_view bytes, const TreeKey& key);

}  // namespace poise::geometry
