// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <memory>

#include "parallel/executor.h"

namespace poise::parallel {

/// Work on oneTBB's threads, in an arena of our own with `threads` slots, `threads` in [2, 256]; they spin for `spin`
/// without work. Null if oneTBB cannot be started. Exists only where POISE_HAVE_TBB is defined.
std::unique_ptr<Executor> make_tbb_executor(int threads, std::chrono::nanoseconds spin);

}  // namespace poise::parallel
