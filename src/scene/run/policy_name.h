// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "poise/scheduler/policy.h"

namespace poise::io {

/// A policy and its name in scenes, on the command line and in results.
struct NamedPolicy {
  const char* name;
  scheduler::PolicyKind kind;
};
/// Those that a file or a command line may name.
inline constexpr std::array kPolicies{NamedPolicy{"perceptual", scheduler::PolicyKind::Perceptual},
                                      NamedPolicy{"fifo", scheduler::PolicyKind::Fifo},
                                      NamedPolicy{"random", scheduler::PolicyKind::Random},
                                      NamedPolicy{"round-robin", scheduler::PolicyKind::RoundRobin},
                                      NamedPolicy{"size", scheduler::PolicyKind::Size},
                                      NamedPolicy{"deepest", scheduler::PolicyKind::Deepest},
                                      NamedPolicy{"equal-levels", scheduler::PolicyKind::EqualLevels}};

/// Their names, for messages and options.
inline constexpr std::array<std::string_view, kPolicies.size()> kPolicyNames = [] {
  std::array<std::string_view, kPolicies.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kPolicies[i].name;
  return names;
}();

/// The name of a policy; that of a host's function is `custom`.
inline const char* policy_name(scheduler::PolicyKind kind) {
  for (const NamedPolicy& named : kPolicies) {
    if (named.kind == kind) return named.name;
  }
  return "custom";
}

/// The policy of a name; empty if there is none of that name.
inline const NamedPolicy* policy_named(std::string_view name) {
  for (const NamedPolicy& named : kPolicies) {
    if (name == named.name) return &named;
  }
  return nullptr;
}

}  // namespace poise::io
