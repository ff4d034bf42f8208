// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace poise {

/// A duration in milliseconds, the unit of reports and tables.
inline double ms(std::chrono::nanoseconds time) { return static_cast<double>(time.count()) / 1e6; }

}  // namespace poise
