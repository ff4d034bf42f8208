// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "poise/trace.h"
#include "scene/result_file.h"
#include "scene/run/run_report.h"

namespace poise::app {

/// Spans that a run's trace may have: 80,000 frames on two threads. Their memory (56 MB) is touched only as they come.
inline constexpr std::size_t kTraceRoom = std::size_t{1} << 20U;

/// Writes the trace of a run and closes the file. `frames` are the run's, in order, and `pairs` as in io::append_spans.
Status write_trace(io::AtomicFile& file, const std::string& scene, int threads, const Trace& trace,
                   std::span<const std::array<std::uint64_t, 2>> pairs, std::span<const simulation::RunFrame> frames);

}  // namespace poise::app
