// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "poise/types.h"

namespace poise {

/// Stage of a trace span. The stages of a step follow each other without gaps; Worker spans lie within Refine, and a
/// Piece within each: the longest piece of refinement of that worker.
enum class TraceStage : std::uint8_t {
  Frame,
  Predict,
  BroadPhase,
  Coarse,
  Refine,
  Manifolds,
  Solve,
  Integrate,
  Publish,
  Worker,
  Piece
};

/// The name in trace files: `frame`, `predict`, `broad_phase`, `coarse`, `refine`, `manifolds`, `solve`, `integrate`,
/// `publish`, `jobs` for Worker, or `piece`. Static storage. Any thread.
const char* trace_name(TraceStage stage);

/// A time span of one thread.
struct TraceSpan {
  std::chrono::steady_clock::time_point begin{}, end{};
  std::uint64_t frame = 0;  ///< FrameReport::frame
  std::uint32_t jobs = 0;   ///< Worker: levels that it completed; else 0
  std::uint32_t units = 0;  ///< Piece: its node-pair expansions; else 0
  BodyId body_a, body_b;    ///< Piece: the pair that it was of
  std::int16_t lane = 0;    ///< number of the worker; 0 is the thread that calls World::step
  TraceStage stage = TraceStage::Frame;
};

/// Time spans of the threads of World::step (StepInput::trace). Invariant: never more spans than the capacity, so that
/// step does not allocate; further spans are discarded and counted. Used by one World at a time; read it between steps.
class Trace {
 public:
  explicit Trace(std::size_t capacity) : capacity_(capacity) { spans_.reserve(capacity); }
  void add(const TraceSpan& span) {
    if (spans_.size() < capacity_) {
      spans_.push_back(span);
    } else {
      ++discarded_;
    }
  }
  [[nodiscard]] const std::vector<TraceSpan>& spans() const { return spans_; }
  [[nodiscard]] std::uint64_t discarded() const { return discarded_; }
  /// Removes the spans. Capacity and count of discarded spans stay.
  void clear() { spans_.clear(); }

 private:
  std::vector<TraceSpan> spans_;
  std::size_t capacity_;
  std::uint64_t discarded_ = 0;
};

}  // namespace poise
