// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/run/run_report.h"

namespace poise::simulation {
namespace {

/// `sorted` must not be empty.
double nearest_rank(const std::vector<double>& sorted, double share) {
  // 0.99 * 100 is slightly above 99 in binary; the rank must not become 100.
  const double rank = std::ceil(share * static_cast<double>(sorted.size()) * (1 - 1e-12));
  const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  return sorted[std::min(index, sorted.size() - 1)];
}

/// The continued fraction of the incomplete beta function (DLMF 8.17.22), evaluated by Lentz's method from the front.
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  constexpr int kTerms = 100000;
  const auto away_from_zero = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
  double c = 1;
  double d = 1 / away_from_zero(1 - (a + b) * x / (a + 1));
  double value = d;
  for (int m = 1; m < kTerms; ++m) {
    const double k = m;
    const double even = k * (b - k) * x / ((a + 2 * k - 1) * (a + 2 * k));
    d = 1 / away_from_zero(1 + even * d);
    c = away_from_zero(1 + even / c);
    value *= c * d;
    const double odd = -(a + k) * (a + b + k) * x / ((a + 2 * k) * (a + 2 * k + 1));
    d = 1 / away_from_zero(1 + odd * d);
    c = away_from_zero(1 + odd / c);
    value *= c * d;
    if (std::abs(c * d - 1) < 1e-15) break;
  }
  return value;
}

/// The x at which I_x(a, b) = share, by bisection: I increases with x.
double beta_quantile(double a, double b, double share) {
  double low = 0;
  double high = 1;
  for (int i = 0; i < 200 && high - low > 1e-16 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (incomplete_beta(a, b, middle) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return nearest_rank(values, share);
}

Percentiles percentiles(std::vector<double> values) {
  Percentiles result;
  if (values.empty()) return result;
  std::sort(values.begin(), values.end());
  result.p50 = nearest_rank(values, 0.5);
  result.p90 = nearest_rank(values, 0.9);
  result.p95 = nearest_rank(values, 0.95);
  result.p99 = nearest_rank(values, 0.99);
  result.p99_9 = nearest_rank(values, 0.999);
  result.max = values.back();
  double sum = 0;
  for (const double value : values) sum += value;
  result.mean = sum / static_cast<double>(values.size());
  return result;
}

double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  // The fraction converges fast only on this side; the other side follows from I_x(a, b) = 1 - I_{1-x}(b, a).
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

Interval clopper_pearson(std::uint64_t hits, std::uint64_t trials, double confidence) {
  Interval interval;
  if (trials == 0) return interval;
  const double tail = 0.5 * (1 - confidence);
  const auto k = static_cast<double>(hits);
  const auto n = static_cast<double>(trials);
  if (hits > 0) interval.low = beta_quantile(k, n - k + 1, tail);
  if (hits < trials) interval.high = beta_quantile(k + 1, n - k, 1 - tail);
  return interval;
}

}  // namespace poise::simulation
