// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "parallel/executor.h"

namespace poise::parallel {

/// Worker loops on oneTBB's threads, in an arena of our own with `threads` slots, `threads` in [2, 256]. Null if oneTBB
/// cannot be started. Exists only where POISE_HAVE_TBB is defined.
std::unique_ptr<Executor> make_tbb_executor(int threads);

}  // namespace poise::parallel
