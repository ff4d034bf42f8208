// SPDX-License-Identifier: MIT
#pragma once

#include "poise/scheduler/policy.h"

namespace poise::io {

/// The name in scenes, on the command line and in results.
inline const char* policy_name(scheduler::PolicyKind kind) {
  switch (kind) {
    case scheduler::PolicyKind::Perceptual:
      return "perceptual";
    case scheduler::PolicyKind::Fifo:
      return "fifo";
    case scheduler::PolicyKind::Custom:
      return "custom";
    case scheduler::PolicyKind::Random:
      return "random";
  }
  return "perceptual";
}

}  // namespace poise::io
