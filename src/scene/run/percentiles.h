// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace poise::simulation {

/// Percentiles of a set of values by nearest rank: the smallest value that at least the named share of them does not
/// exceed. All are 0 for an empty set.
struct Percentiles {
  double p50 = 0, p90 = 0, p95 = 0, p99 = 0, p99_9 = 0, max = 0, mean = 0;
};
/// `values` must be finite, share in (0, 1]. Returns 0 for an empty set. The order of the values does not matter.
double percentile(std::vector<double> values, double share);
Percentiles percentiles(std::vector<double> values);

}  // namespace poise::simulation
