// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace poise {

/// What a stretch of a frame's time went into. The stages of a step follow each other and fill it; Worker lies in
/// Refine.
enum class TraceStage : std::uint8_t {
  Frame,
  Predict,
  BroadPhase,
  Coarse,
  Refine,
  Response,
  Integrate,
  Publish,
  Worker
};

/// `frame`, `predict`, `broad_phase`, `coarse`, `refine`, `response`, `integrate`, `publish`, or `jobs` for Worker.
const char* trace_name(TraceStage stage);

/// A stretch of time of one thread.
struct TraceSpan {
  std::chrono::steady_clock::time_point begin{}, end{};
  std::uint64_t frame = 0;  ///< FrameReport::frame
  std::uint32_t jobs = 0;   ///< Worker: levels that it completed, else 0
  std::int16_t lane = 0;    ///< number of the worker; 0 is the thread that calls World::step
  TraceStage stage = TraceStage::Frame;
};

/// Where World::step leaves what its threads did when (StepInput::trace). Invariant: never more spans than the room
/// that it was made with, so that step does not allocate; what found no room is counted. Belongs to one World at a
/// time; read it between steps.
class Trace {
 public:
  explicit Trace(std::size_t room) : room_(room) { spans_.reserve(room); }
  void add(const TraceSpan& span) {
    if (spans_.size() < room_) {
      spans_.push_back(span);
    } else {
      ++dropped_;
    }
  }
  [[nodiscard]] const std::vector<TraceSpan>& spans() const { return spans_; }
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
  /// Forgets the spans and keeps the room and the count of the dropped.
  void clear() { spans_.clear(); }

 private:
  std::vector<TraceSpan> spans_;
  std::size_t room_;
  std::uint64_t dropped_ = 0;
};

}  // namespace poise
