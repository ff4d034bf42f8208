// SPDX-License-Identifier: MIT
#pragma once

#include "poise/result.h"

namespace poise::app {

inline constexpr int kExitDone = 0;
inline constexpr int kExitRequirementFailed = 1;
inline constexpr int kExitBadUsage = 2;
inline constexpr int kExitBadInput = 3;
inline constexpr int kExitOutputFailed = 4;
inline constexpr int kExitStopped = 130;

/// The exit code for a refusal by the library.
inline int exit_code_of(const Error& error) {
  if (error.kind == ErrorKind::Cancelled) return kExitStopped;
  return error.kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadInput;
}

}  // namespace poise::app
