// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "arguments.h"
#include "poise/step.h"

namespace poise::python {

/// A budget of steps; a time from the start of the step becomes a deadline when the step begins.
struct BudgetValue {
  Budget::Kind kind = Budget::Kind::Unlimited;
  bool from_start = false;
  Nanoseconds span{0};
  SteadyClock::time_point deadline{};
  std::uint64_t work_units = 0;

  static BudgetValue within(Nanoseconds span) {
    return {.kind = Budget::Kind::Deadline, .from_start = true, .span = span};
  }
  /// The budget of a step that begins now.
  [[nodiscard]] Budget resolved() const;
};

/// The report of a step: the columns of `poise run --frames-csv`, made when they are asked for.
struct ReportValue {
  FrameReport report;
  double time_s = 0;  ///< at the end of the frame, where the caller knows it
  bool has_time = false;
  py::object columns = py::none();  ///< a dict, once they were asked for
};

/// The columns of ReportValue.
const std::vector<std::string>& report_columns();
/// All of them as a dict, made once.
py::dict columns_of(ReportValue& value);

void bind_step_values(py::module_& module);

}  // namespace poise::python
