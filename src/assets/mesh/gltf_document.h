// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assets/json/json_document.h"
#include "poise/result.h"
#include "poise/types.h"

namespace poise::geometry {

/// The lists of a glTF file that geometry needs.
enum class GltfList : std::uint8_t { Scenes, Nodes, Meshes, Accessors, BufferViews, Buffers };

/// Numbers that a file may repeat beyond its bytes, three of a vertex and one of a corner. Chosen.
inline constexpr std::uint64_t kMostRepeatedNumbers = 2'000'000;

/// A glTF or GLB file of version 1 or 2 with the buffers that were asked for. The lists of version 2 are arrays, those
/// of version 1 objects, whose entries have a number here too. Invariant: buffers that were read stay where they are.
class GltfDocument {
 public:
  /// `bytes` must outlive it. Refused: what is neither JSON nor a container.
  static Result<GltfDocument> open(std::string_view bytes, const std::filesystem::path& folder);

  [[nodiscard]] const io::JsonValue& root() const { return root_; }
  [[nodiscard]] io::JsonValue::Items entries(GltfList list) const;
  /// The number of the entry that a value names; none where there is no such entry.
  [[nodiscard]] std::optional<std::size_t> find(GltfList list, const io::JsonValue& name) const;
  /// An entry in the form of messages: `nodes[3]`, `meshes.wheel`.
  [[nodiscard]] std::string place(GltfList list, std::size_t entry) const;

  /// The values of an accessor, charged for; points are appended. Refused with its place: what does not lie in its
  /// buffer.
  Status add_points(const io::JsonValue& name, std::vector<Vec3>& points);
  Status read_indices(const io::JsonValue& name, std::vector<std::uint32_t>& indices);

  /// Everything that a file may make its reader do again and again is charged for before it is done: `numbers` of
  /// coordinates, corners, members or letters. Refused where they are more than kMostRepeatedNumbers and the bytes of
  /// the file and of the buffers that were read.
  Status charge(std::uint64_t numbers);
  /// Charges for a value that is looked at: its members or letters and 1.
  Status charge(const io::JsonValue& value) { return charge(1 + value.items().size() + value.text().size()); }

 private:
  /// Where the values of an accessor, or of a part of a sparse one, are.
  struct Span {
    std::string_view bytes;
    std::size_t stride = 0;
    std::uint64_t component = 0;
  };
  /// What is asked of an accessor.
  struct Wanted {
    std::string_view type;
    std::size_t components = 1;
    bool whole = false;  ///< the components are whole numbers without sign
  };
  struct Accessor;

  GltfDocument() = default;
  Result<Accessor> accessor(const io::JsonValue& name, const Wanted& wanted);
  Status read_sparse(const io::JsonValue& sparse, const Wanted& wanted, Accessor& accessor);
  Result<Span> span(const io::JsonValue& owner, const std::string& place, std::uint64_t count, std::size_t components,
                    std::uint64_t component, const io::JsonValue* stride);
  Result<std::string_view> view(const io::JsonValue& name, const std::string& place, std::uint64_t& stride);
  Result<std::string_view> buffer(std::size_t entry);
  Result<std::string_view> read_buffer(std::size_t entry);
  Result<std::string_view> load(const io::JsonValue& uri, const std::string& place);

  io::JsonValue root_;
  std::array<const io::JsonValue*, 6> lists_{};  ///< members of root_, or nullptr
  std::string_view binary_;                      ///< of a container
  std::filesystem::path folder_;
  std::array<std::vector<std::uint32_t>, 6> by_name_;  ///< entries of an object, sorted
  std::map<std::size_t, std::string_view> buffers_;    ///< by entry; each is looked for once
  std::map<std::size_t, std::string> embedded_;        ///< by entry
  std::map<std::string, std::string> files_;           ///< by name, so that none is held twice
  std::uint64_t bytes_read_ = 0;                       ///< of the file and of the buffers
  std::uint64_t charged_ = 0;
};

/// A member that is a whole number, `otherwise` if it is missing; none if it is something else.
std::optional<std::uint64_t> whole_member(const io::JsonValue& object, std::string_view name, std::uint64_t otherwise);

}  // namespace poise::geometry
