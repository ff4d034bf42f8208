// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "poise/scheduler/policy.h"

namespace poise::io {

/// A policy in a file of its own, `poise.policy/1`: a name, and what a scene's `policy` may have. `evidence` of the
/// file, an object, says how the policy was found (`poise tune`); nothing depends on it.
struct PolicyFile {
  std::string name;
  scheduler::Policy policy;
};

/// Whether a text on the command line means a policy file and not a policy: it has a folder, or ends in `.json`.
bool names_policy_file(std::string_view text);

/// Reads a policy file. Members that it does not have are those of `base`. Refused with file, field, value and rule;
/// `errors`, if given, receives all refusals, one line each.
Result<PolicyFile> read_policy_file(const std::filesystem::path& file, const scheduler::Policy& base,
                                    std::vector<std::string>* errors = nullptr);

/// Sets a weight by `CUE=VALUE`. Refused, without the option's name: another form, an unknown cue, a value out of
/// range.
Status set_weight(std::string_view text, scheduler::Policy& policy);

}  // namespace poise::io
