// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "poise/result.h"
#include "record/record.h"

/// The parts of a record as bytes (docs/record.md). Reading refuses bytes that no writer makes, reads no byte beyond
/// them and takes no more memory than they do, whatever they are.
namespace poise::io {

/// Appends a frame.
void write_frame(const RecordedFrame& frame, std::string& out);
/// Uses the room of `frame` again; what it holds after a refusal counts for nothing.
Status read_frame(std::string_view bytes, RecordedFrame& frame);

void write_end(const RecordEnd& end, std::string& out);
Status read_end(std::string_view bytes, RecordEnd& end);

/// The header but for the scene's text, as JSON.
std::string header_json(const RecordHeader& header);
/// Refused with the field, its value and the rule; `name` begins every message. scene_text stays empty.
Result<RecordHeader> read_header(std::string_view json, const std::string& name);

}  // namespace poise::io
