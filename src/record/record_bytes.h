// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "poise/result.h"
#include "record/record.h"

/// The parts of a record as bytes (docs/record.md). Reading refuses bytes that no writer produces, never reads beyond
/// the given bytes, and uses memory proportional to them, for any input.
namespace poise::io {

/// Appends a frame.
void write_frame(const RecordedFrame& frame, std::string& out);
/// Reads a frame; reuses the capacity of `frame`, whose content is unspecified after a refusal.
Status read_frame(std::string_view bytes, RecordedFrame& frame);

void write_end(const RecordEnd& end, std::string& out);
Status read_end(std::string_view bytes, RecordEnd& end);

/// The header without the scene's text, as JSON.
std::string header_json(const RecordHeader& header);
/// Refused with the field, its value and the rule; `name` begins every message. scene_text stays empty.
Result<RecordHeader> read_header(std::string_view json, const std::string& name);

}  // namespace poise::io
