// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "capture/packed_pose.h"
#include "capture/pair_code.h"
#include "poise/result.h"

namespace poise::capture {

/// A body of a frame before it is packed.
struct SeenBody {
  std::uint64_t number = 0;  ///< ascending in a frame; a number that has left does not come back
  Pose pose;
  std::uint8_t activity = 0, level = 0, priority = 0;
};

/// A contact of a frame before it is packed; bodies by number.
struct SeenContact {
  std::uint64_t a = 0, b = 0;
  Level level = 0;  ///< kPolygonBin for polygons
  Vec3 normal = Vec3::UnitZ();
  std::uint8_t point_count = 0;
  std::array<Vec3, Contact::kMostPoints> points_m{};
};

/// A pair of a frame before it is packed: `packed` but for its rows; bodies by number.
struct SeenPair {
  std::uint64_t a = 0, b = 0;
  PackedPair packed;
};

/// What is handed over of a frame. Its memory is used again.
struct SeenFrame {
  FrameFacts facts;
  std::vector<CapturedBody> new_bodies;  ///< in no frame before, ascending
  std::vector<SeenBody> bodies;
  std::vector<SeenContact> contacts;  ///< in order of a
  std::vector<SeenPair> pairs;        ///< where the header asks for them
};

/// Writes a capture on a thread of its own while the run goes on. The file has its name from its header on and is
/// written block by block, so that what a run has written stays when it is killed. Invariant: at most a stated number
/// of frames waits to be written.
///
/// One thread uses it, the one that made it.
class CaptureWriter {
 public:
  /// Frames that may wait. Chosen: a second, for a disk that is busy.
  static constexpr std::size_t kFramesWaiting = 60;

  /// The thread is made here, so that it runs where its maker may run now. A file that is there stays until
  /// begin() has written what takes its place. Refused as OutputFailed: a path that cannot be written.
  static Result<CaptureWriter> open(const std::filesystem::path& path, std::size_t frames_waiting = kFramesWaiting);
  CaptureWriter(CaptureWriter&&) noexcept;
  CaptureWriter& operator=(CaptureWriter&&) noexcept;
  ~CaptureWriter();

  /// Before the first frame. Refused: what cannot be written.
  Status begin(const CaptureHeader& header);
  /// What could not be written of the frames that were handed over, if that is known by now.
  [[nodiscard]] Status failure() const;
  /// Whether a frame can be handed over without waiting.
  [[nodiscard]] bool has_room() const;
  /// A frame to be filled, empty but for its memory.
  [[nodiscard]] SeenFrame fresh();
  /// Hands a frame over; waits until there is room. Its facts.left_out is set here.
  void add(SeenFrame frame);
  /// A frame is not captured: the next one that is says so.
  void leave_out();
  [[nodiscard]] std::uint64_t left_out() const;
  /// Frames that were handed over.
  [[nodiscard]] std::uint64_t frames() const;
  /// Writes what waits, the index and the trailer. Refused: what could not be written, now or before; the file then
  /// ends with the last whole block.
  Status finish(bool stopped);
  /// Size of the file, after finish().
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  struct Impl;
  explicit CaptureWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace poise::capture
