// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <memory>

#include "parallel/executor.h"

namespace poise::parallel {

/// An executor on oneTBB's threads, in its own arena with `threads` slots, in [2, 256]; threads without work spin for
/// `spin`. Null if oneTBB cannot be started. Exists only if POISE_HAVE_TBB is defined.
std::unique_ptr<Executor> make_tbb_executor(int threads, std::chrono::nanoseconds spin);

}  // namespace poise::parallel
