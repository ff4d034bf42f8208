// SPDX-License-Identifier: MIT
#include "assets/cache/tree_cache_entry.h"

#include <xxhash.h>

#include <cstring>
#include <type_traits>

#include <fmt/format.h>

#include "geometry/sphere_tree/tree_check.h"
#include "geometry/sphere_tree/tree_layout.h"
#include "geometry_hash.h"

namespace poise::geometry {
namespace {

// The file holds every array of the tree: a new array must be added to each_array too.
static_assert(sizeof(SphereTree) == 10 * sizeof(std::vector<float>));
static_assert(sizeof(NodeFit) == 24 && std::is_trivially_copyable_v<NodeFit>);

constexpr std::size_t kHashBytes = 16;
/// Version of the file's layout; kTreeVersion is the version of the arrays' meaning.
constexpr std::uint32_t kEntryVersion = 1;
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::size_t kNodeBytes = 6 * sizeof(float) + sizeof(NodeFit) + sizeof(NodeIndex) + sizeof(std::uint8_t);

constexpr std::size_t most_nodes() {
  std::size_t nodes = 0;
  std::size_t on_level = 1;
  for (Level level = 0; level <= kMaxTreeDepth; ++level, on_level *= kTreeBranching) nodes += on_level;
  return nodes;
}

struct Head {
  std::array<char, 8> magic{'p', 'o', 'i', 's', 'e', 't', 'r', '\n'};
  std::uint32_t byte_order = kByteOrder;
  std::uint32_t entry_version = kEntryVersion;
  std::uint32_t tree_version = kTreeVersion;
  std::uint32_t nodes = 0;
  std::uint32_t level_bounds = 0;  ///< entries of level_begin
  std::uint32_t zero = 0;
  TreeKey key{};
};
static_assert(sizeof(Head) == 48 && std::has_unique_object_representations_v<Head>);

/// Calls visit for each array of a tree with the number of its entries in the file.
template <class Tree, class Visit>
void each_array(Tree& tree, std::size_t nodes, std::size_t level_bounds, Visit&& visit) {
  for (auto* array :
       {&tree.x_m, &tree.y_m, &tree.z_m, &tree.radius_m, &tree.protrusion_max_m, &tree.protrusion_mean_m}) {
    visit(*array, nodes);
  }
  visit(tree.fit, nodes);
  visit(tree.first_child, nodes);
  visit(tree.child_count, nodes);
  visit(tree.level_begin, level_bounds);
}

TreeKey hash_of(const void* bytes, std::size_t size) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits(bytes, size));
  TreeKey key;
  std::memcpy(key.data(), canonical.digest, key.size());
  return key;
}

}  // namespace

const std::uint64_t kMostEntryBytes =
    sizeof(Head) + most_nodes() * kNodeBytes + (kMaxTreeDepth + 2) * sizeof(NodeIndex) + kHashBytes;

TreeKey tree_key(const TriangleMesh& mesh, const TreeBuildOptions& options) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(mesh.triangles[0]) == 3 * sizeof(std::uint32_t));
  const TreeKey vertices = hash_of(mesh.vertices_m.data(), mesh.vertices_m.size() * sizeof(Vec3));
  const TreeKey triangles = hash_of(mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(std::uint32_t));
  const std::string all =
      fmt::format("poise tree {} {} builder {} order {} mesh {} {} {} {} depth {} preset {} solidity {} seed {}",
                  kTreeVersion, kEntryVersion, POISE_BUILD_GEOMETRY, kByteOrder, mesh.vertices_m.size(),
                  mesh.triangles.size(), key_text(vertices), key_text(triangles), options.depth,
                  static_cast<int>(options.preset), static_cast<int>(options.solidity), options.seed);
  return hash_of(all.data(), all.size());
}

std::string key_text(const TreeKey& key) {
  std::string text;
  for (const std::uint8_t byte : key) text += fmt::format("{:02x}", byte);
  return text;
}

std::string entry_bytes(const SphereTree& tree, const TreeKey& key) {
  Head head;
  head.nodes = static_cast<std::uint32_t>(tree.node_count());
  head.level_bounds = static_cast<std::uint32_t>(tree.level_begin.size());
  head.key = key;
  std::string bytes(reinterpret_cast<const char*>(&head), sizeof head);
  each_array(tree, head.nodes, head.level_bounds, [&](const auto& array, std::size_t count) {
    bytes.append(reinterpret_cast<const char*>(array.data()), count * sizeof(array[0]));
  });
  const TreeKey checksum = hash_of(bytes.data(), bytes.size());
  bytes.append(reinterpret_cast<const char*>(checksum.data()), checksum.size());
  return bytes;
}

std::optional<SphereTree> entry_tree(std::string_view bytes, const TreeKey& key) {
  Head head;
  if (bytes.size() < sizeof head + kHashBytes) return std::nullopt;
  std::memcpy(&head, bytes.data(), sizeof head);
  Head wanted;
  wanted.nodes = head.nodes;
  wanted.level_bounds = head.level_bounds;
  wanted.key = key;
  if (std::memcmp(&head, &wanted, sizeof head) != 0) return std::nullopt;
  if (head.nodes < 1 || head.nodes > most_nodes()) return std::nullopt;
  if (head.level_bounds < 2 || head.level_bounds > kMaxTreeDepth + 2U) return std::nullopt;
  const std::size_t payload = head.nodes * kNodeBytes + head.level_bounds * sizeof(NodeIndex);
  if (bytes.size() != sizeof head + payload + kHashBytes) return std::nullopt;
  const std::string_view hashed = bytes.substr(0, sizeof head + payload);
  const TreeKey checksum = hash_of(hashed.data(), hashed.size());
  if (std::memcmp(checksum.data(), bytes.data() + hashed.size(), kHashBytes) != 0) return std::nullopt;

  SphereTree tree;
  const char* from = bytes.data() + sizeof head;
  each_array(tree, head.nodes, head.level_bounds, [&](auto& array, std::size_t count) {
    array.resize(count);
    std::memcpy(static_cast<void*>(array.data()), from, count * sizeof(array[0]));
    from += count * sizeof(array[0]);
  });
  if (tree.node_count() != head.nodes) return std::nullopt;
  pad_tree(tree);
  if (!why_not_tree(tree).empty()) return std::nullopt;
  return tree;
}

}  // namespace poise::geometry
