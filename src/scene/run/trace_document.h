// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "poise/trace.h"
#include "scene/run/run_report.h"

namespace poise::io {

/// What a trace is of.
struct TraceHead {
  std::string process;  ///< as a viewer shows it
  int threads = 1;
  std::uint64_t discarded = 0;  ///< spans beyond the capacity
};

/// A trace in pieces, joined a JSON array of Chrome trace events ("Trace Event Format", D. Sinclair, Google 2016;
/// ui.perfetto.dev and chrome://tracing open it): names of the lanes, then spans ("X", times in microseconds from
/// `zero`), then what is counted once a frame ("C": budget and reserve in ms, misses so far, contacts by level) with a
/// mark ("i") for each miss, then the end.
std::string trace_begin(const TraceHead& head);
void append_spans(std::span<const TraceSpan> spans, SteadyClock::time_point zero, std::string& out);
/// `misses` is the count before the frame and goes on with it.
void append_counters(const simulation::RunFrame& frame, SteadyClock::time_point zero, std::uint64_t& misses,
                     std::string& out);
std::string trace_end(const TraceHead& head);

}  // namespace poise::io
