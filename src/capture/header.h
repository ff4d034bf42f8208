// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/capture.h"
#include "poise/result.h"

/// The chunks of a capture but those of frames, as bytes (docs/capture.md). Reading refuses what no writer makes, with
/// the field, its value and the rule, and uses memory in proportion to the bytes.
namespace poise::capture {

/// HEAD.
std::string header_json(const CaptureHeader& header);
/// Shapes have no triangles and no spheres yet.
Result<CaptureHeader> read_header(std::string_view json);

/// SHAP.
std::string shape_bytes(std::uint32_t index, const CapturedShape& shape);
/// Fills the next shape of a header.
Status read_shape(std::string_view bytes, std::uint32_t index, CapturedShape& shape);

/// BODY: rows from `first` on.
std::string bodies_json(std::size_t first, std::span<const CapturedBody> bodies);
/// Appends to the rows that were read before.
Status read_bodies(std::string_view json, const CaptureHeader& header, std::vector<CapturedBody>& bodies);

/// A block in the file.
struct BlockPlace {
  std::uint64_t at = 0;           ///< offset of its chunk
  std::uint64_t first_frame = 0;  ///< number of its first frame
  std::uint32_t frames = 0;
};
/// INDX.
struct CaptureIndex {
  std::vector<BlockPlace> blocks;
  std::vector<std::uint64_t> bodies;  ///< offsets of BODY chunks
  CaptureEnd end;
};
std::string index_json(const CaptureIndex& index);
Result<CaptureIndex> read_index(std::string_view json);

}  // namespace poise::capture
