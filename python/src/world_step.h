// SPDX-License-Identifier: MIT
#pragma once

#include "step_values.h"
#include "world_value.h"

namespace poise::python {

/// A Budget, or None for an unlimited one; anything else raises TypeError.
BudgetValue budget_of(const py::object& given);

void bind_step(WorldClass& world);

}  // namespace poise::python
