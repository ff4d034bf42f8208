// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "arguments.h"
#include "poise/scheduler/policy.h"
#include "poise/world.h"

namespace poise::python {

/// A policy with the Python functions that belong to it; `policy` itself holds no functions.
struct PolicyValue {
  scheduler::Policy policy;
  py::object cue = py::none();
  py::object custom = py::none();
};

/// Settings of a World with their policy; `settings.policy` is not used.
struct SettingsValue {
  WorldSettings settings;
  PolicyValue policy;
  SettingsValue();
};

/// Raises poise.Error for a policy that the library refuses, with the field.
void check_policy(const PolicyValue& policy);
/// A Policy, or the name of one of its kinds, which changes the kind of `base` alone.
PolicyValue policy_of(const py::object& given, const PolicyValue& base);
/// The name of a policy: `perceptual`, ..., or `custom`.
std::string kind_of(const PolicyValue& policy);

void bind_policy(py::module_& module);
void bind_settings(py::module_& module);

}  // namespace poise::python
