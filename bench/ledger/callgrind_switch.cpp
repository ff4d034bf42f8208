// SPDX-License-Identifier: MIT
#include "ledger/callgrind_switch.h"

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>

namespace poise::ledger {

bool can_switch_callgrind() { return true; }
bool under_valgrind() { return RUNNING_ON_VALGRIND != 0; }
void start_instrumentation() { CALLGRIND_START_INSTRUMENTATION; }
void toggle_collection() { CALLGRIND_TOGGLE_COLLECT; }

}  // namespace poise::ledger

#else

namespace poise::ledger {

bool can_switch_callgrind() { return false; }
bool under_valgrind() { return false; }
void start_instrumentation() {}
void toggle_collection() {}

}  // namespace poise::ledger

#endif
