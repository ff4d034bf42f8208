// SPDX-License-Identifier: MIT
#pragma once

#include "parallel/interrupt.h"
#include "poise/result.h"

namespace poise::app {

inline constexpr int kExitDone = 0;
inline constexpr int kExitRequirementFailed = 1;
inline constexpr int kExitBadUsage = 2;
inline constexpr int kExitBadInput = 3;
inline constexpr int kExitOutputFailed = 4;

/// After a signal that stopped the command: 128 and its number, as shells have it. 130 for Ctrl-C, 143 for SIGTERM.
inline int exit_stopped() { return 128 + parallel::stop_signal(); }

/// The exit code for a refusal by the library.
inline int exit_code_of(const Error& error) {
  if (error.kind == ErrorKind::Cancelled) return exit_stopped();
  return error.kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadInput;
}

}  // namespace poise::app
