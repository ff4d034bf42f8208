// SPDX-License-Identifier: MIT
#pragma once

namespace poise::ledger {

/// Was this program compiled with valgrind's headers, so that it can tell callgrind what to count?
bool can_switch_callgrind();
/// Does it run under valgrind now?
bool under_valgrind();
/// From here on callgrind translates code so that it can be counted; until then a run costs a fifth of that.
void start_instrumentation();
/// Begins or ends counting.
void toggle_collection();

}  // namespace poise::ledger
