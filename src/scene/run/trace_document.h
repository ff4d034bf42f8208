// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "poise/trace.h"
#include "scene/run/run_report.h"

namespace poise::io {

/// Header of a trace.
struct TraceHead {
  std::string process;  ///< name that a viewer displays
  int threads = 1;
  std::uint64_t discarded = 0;  ///< spans beyond the capacity
};

/// A trace in pieces, which together are a JSON array of Chrome trace events ("Trace Event Format", D. Sinclair, Google
/// 2016; ui.perfetto.dev and chrome://tracing open it). The pieces are: names of the lanes; spans ("X", times in
/// microseconds from `zero`); counters once a frame ("C": budget and reserve in ms, misses so far, contacts by level),
/// with a mark ("i") for each miss; the end.
std::string trace_begin(const TraceHead& head);
/// `pairs`: of each piece among the spans, in order, the numbers of its bodies; 0 where there are fewer.
void append_spans(std::span<const TraceSpan> spans, std::span<const std::array<std::uint64_t, 2>> pairs,
                  SteadyClock::time_point zero, std::string& out);
/// `misses` is the count before the frame, and is updated.
void append_counters(const simulation::RunFrame& frame, SteadyClock::time_point zero, std::uint64_t& misses,
                     std::string& out);
std::string trace_end(const TraceHead& head);

}  // namespace poise::io
