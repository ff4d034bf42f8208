// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace poise::simulation {

/// Of a set of values: nearest rank, the smallest value that at least the named share of them does not exceed. All 0
/// for an empty set.
struct Percentiles {
  double p50 = 0, p90 = 0, p95 = 0, p99 = 0, p99_9 = 0, max = 0, mean = 0;
};
/// `values` finite; share in (0, 1]. 0 for an empty set. The order of the values does not matter.
double percentile(std::vector<double> values, double share);
Percentiles percentiles(std::vector<double> values);

}  // namespace poise::simulation
