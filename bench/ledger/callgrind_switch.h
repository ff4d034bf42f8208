// SPDX-License-Identifier: MIT
#pragma once

namespace poise::ledger {

/// Whether this program was compiled with valgrind's headers, so that it can control callgrind.
bool can_switch_callgrind();
/// Whether the program is running under valgrind.
bool under_valgrind();
/// Starts callgrind's instrumentation; before this a run takes a fifth of the time.
void start_instrumentation();
/// Starts or stops counting.
void toggle_collection();

}  // namespace poise::ledger
