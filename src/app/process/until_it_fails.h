// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "app/process/progress.h"
#include "app/process/standard_streams.h"
#include "poise/result.h"

namespace poise::app {

/// A function of frames that writes them, until it is refused as OutputFailed: then `command` warns, and it does
/// nothing from then on, so that the frames and their other files go on. What else it refuses is passed on. An empty
/// function stays empty. `progress` must outlive it.
template <class Sink>
Sink until_it_fails(const char* command, Sink sink, Progress& progress) {
  if (!sink) return {};
  return [command, sink = std::move(sink), &progress, failed = false](const auto&... frame) mutable -> Status {
    if (failed) return Done{};
    Status written = sink(frame...);
    if (written || written.error().kind != ErrorKind::OutputFailed) return written;
    failed = true;
    progress.end();
    print_error("poise {}: warning: {}; the run goes on without it\n", command, written.error().message);
    return Done{};
  };
}

}  // namespace poise::app
