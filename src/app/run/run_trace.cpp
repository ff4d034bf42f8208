// SPDX-License-Identifier: MIT
#include "app/run/run_trace.h"

#include <algorithm>

#include "scene/run/trace_document.h"

namespace poise::app {

Status write_trace(io::AtomicFile& file, const std::string& scene, int threads, const Trace& trace,
                   std::span<const std::array<std::uint64_t, 2>> pairs, std::span<const simulation::RunFrame> frames) {
  constexpr std::size_t kAtOnce = 4096;
  const io::TraceHead head{"poise run " + scene, threads, trace.discarded()};
  const SteadyClock::time_point zero = frames.empty() ? SteadyClock::time_point{} : frames.front().report.started;
  Status written = file.write(io::trace_begin(head));
  const std::span<const TraceSpan> spans(trace.spans());
  std::string text;
  for (std::size_t i = 0; i < spans.size() && written; i += kAtOnce) {
    text.clear();
    const std::span<const TraceSpan> some = spans.subspan(i, std::min(kAtOnce, spans.size() - i));
    io::append_spans(some, pairs, zero, text);
    const auto pieces = std::ranges::count(some, TraceStage::Piece, &TraceSpan::stage);
    pairs = pairs.subspan(std::min(pairs.size(), static_cast<std::size_t>(pieces)));
    written = file.write(text);
  }
  std::uint64_t misses = 0;
  for (std::size_t i = 0; i < frames.size() && written; i += kAtOnce) {
    text.clear();
    for (const simulation::RunFrame& frame : frames.subspan(i, std::min(kAtOnce, frames.size() - i)))
      io::append_counters(frame, zero, misses, text);
    written = file.write(text);
  }
  if (written) written = file.write(io::trace_end(head));
  return written ? file.commit() : written;
}

}  // namespace poise::app
