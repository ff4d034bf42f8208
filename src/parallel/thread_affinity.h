// SPDX-License-Identifier: MIT
#pragma once

#include <pthread.h>

#include "poise/result.h"

namespace poise::parallel {

/// Binds a thread to a processor (>= 0) and gives it a priority under SCHED_FIFO (> 0); -1 and 0 change nothing.
/// Refused: what the system does not permit, with field, value and rule.
Status place_thread(pthread_t thread, int processor, int realtime_priority);

}  // namespace poise::parallel
