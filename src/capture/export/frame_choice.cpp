// SPDX-License-Identifier: MIT
#include "capture/export/frame_choice.h"

#include <fmt/format.h>

namespace poise::capture {

Status read_chosen(CaptureReader& reader, const FrameChoice& choice, const CaptureReader::FrameSink& sink) {
  std::uint64_t next = choice.from;
  std::uint64_t chosen = 0;
  const Status read = reader.read_frames(choice.from, choice.to, [&](const PackedFrame& frame) {
    if (frame.facts.frame < next) return true;
    next = frame.facts.frame + choice.every;
    ++chosen;
    return sink(frame);
  });
  if (!read || chosen > 0) return read;
  if (reader.frames() == 0) return bad_input(reader.name() + ": has no frames");
  return bad_input(fmt::format(
      "{}: has no frame from {}{}", reader.name(), choice.from,
      choice.to == std::numeric_limits<std::uint64_t>::max() ? std::string() : fmt::format(" up to {}", choice.to)));
}

std::string body_name(const CaptureReader& reader, std::uint32_t row) {
  const CapturedBody& body = reader.bodies()[row];
  return body.name.empty() ? fmt::format("{} {}", reader.header().shapes[body.shape].name, body.number) : body.name;
}

}  // namespace poise::capture
