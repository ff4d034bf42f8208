// SPDX-License-Identifier: MIT
#include "capture/capture_reader.h"

#include <xxhash.h>

#include <cstring>
#include <string>
#include <vector>

#include "capture/bytes.h"
#include "capture/chunks.h"
#include "capture/frame_code.h"
#include "fuzz/checks.h"
#include "fuzz/containers.h"

namespace poise::fuzz {
namespace {

std::string with_chunk_checksums(std::string_view bytes) {
  std::string whole(bytes);
  std::size_t at = capture::kMagic.size();
  while (at + capture::kChunkHeadBytes + capture::kChunkTailBytes <= whole.size()) {
    std::uint32_t stored = 0;
    std::memcpy(&stored, whole.data() + at + 8, sizeof stored);
    if (stored > whole.size() - at - capture::kChunkHeadBytes - capture::kChunkTailBytes) break;
    const std::size_t size = capture::kChunkHeadBytes + stored;
    const std::uint32_t sum = XXH32(whole.data() + at, size, 0);
    std::memcpy(whole.data() + at + size, &sum, sizeof sum);
    at += size + capture::kChunkTailBytes;
  }
  return whole;
}

bool read_whole(std::string_view bytes) {
  const MemoryFile file(with_chunk_checksums(bytes), "capture");
  Result<capture::CaptureReader> reader = capture::CaptureReader::open(file.path());
  if (!reader) return checked(reader.error());
  const Status read = reader.value().read_frames(0, ~std::uint64_t{0}, [&](const capture::PackedFrame& frame) {
    require(frame.rows.size() == frame.poses.size(), "a body has a pose");
    for (const std::uint32_t row : frame.rows) require(row < reader.value().bodies().size(), "a row has a body");
    return true;
  });
  return checked(read) && !reader.value().damage();
}

}  // namespace

bool read_capture(std::string_view bytes) {
  if (bytes.starts_with(capture::kMagicOfAny)) return read_whole(bytes);
  if (bytes.empty()) return false;
  const std::string_view part = bytes.substr(1);
  capture::CapturedShape shape;
  capture::CaptureHeader header;
  std::vector<capture::CapturedBody> bodies;
  switch (bytes[0]) {
    case 'H':
      return checked(capture::read_header(part));
    case 'S':
      return checked(capture::read_shape(part, 0, shape));
    case 'B':
      header.shapes.resize(3);
      header.materials.resize(2);
      return checked(capture::read_bodies(part, header, bodies));
    case 'I':
      return checked(capture::read_index(part));
    default: {
      capture::ByteReader frames(part);
      capture::FrameDecoder decoder({1000, 4096, bytes[0] != 'f'});
      capture::PackedFrame frame;
      while (frames.left() > 0) {
        const Status read = decoder.next(frames, frame);
        if (!read) return checked(read.error());
      }
      return true;
    }
  }
}

}  // namespace poise::fuzz
