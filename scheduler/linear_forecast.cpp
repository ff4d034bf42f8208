// SPDX-License-Identifier: MIT
#include "poise/scheduler/linear_forecast.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace poise::scheduler {
namespace {

// Standard deviations as shares: of a coefficient's change from frame to frame, and of one frame's duration. Chosen:
// the forecast follows a machine that changes its speed within about ten frames.
constexpr double kDrift = 0.02;
constexpr double kNoise = 0.1;
// Standard deviation of an unknown coefficient, as a share of its prior plus 1 us.
constexpr double kInitialVariance = 3.0;
// The same for a coefficient that another run has learned. Chosen: scenes differ by about this much.
constexpr double kPriorDeviation = 0.5;
constexpr double kMostPriorUs = 1e9;
// Far beyond any frame, and sums of some of them are within the range of Nanoseconds.
constexpr double kMostUs = 9e12;

}  // namespace

std::optional<Problem> LinearForecast::first_problem(std::span<const ForecastFeature> features) {
  const auto count = static_cast<double>(features.size());
  if (features.empty() || features.size() > kMostFeatures) {
    return Problem{"features.size", count, 1, static_cast<double>(kMostFeatures), {}};
  }
  for (std::size_t i = 0; i < features.size(); ++i) {
    const ForecastFeature& feature = features[i];
    const auto place = static_cast<double>(i);
    if (feature.name.empty()) return Problem{"features.name", place, 0, 0, "must not be empty"};
    for (std::size_t j = 0; j < i; ++j) {
      if (features[j].name == feature.name) return Problem{"features.name", place, 0, 0, "must be unlike the others"};
    }
    if (!(feature.prior_us >= 0 && feature.prior_us <= kMostPriorUs)) {
      return Problem{"features.prior_us", feature.prior_us, 0, kMostPriorUs, {}};
    }
  }
  return std::nullopt;
}

LinearForecast::LinearForecast(std::span<const ForecastFeature> features, std::span<const double> learned_us) {
  if (first_problem(features)) return;
  size_ = features.size();
  for (std::size_t i = 0; i < size_; ++i) {
    name_[i] = features[i].name;
    prior_us_[i] = coefficient_us_[i] = features[i].prior_us;
  }
  const bool known = learned_us.size() == size_ && std::all_of(learned_us.begin(), learned_us.end(),
                                                               [](double us) { return us >= 0 && us <= kMostPriorUs; });
  if (known) std::copy(learned_us.begin(), learned_us.end(), coefficient_us_.begin());
  set_initial_variance(kInitialVariance);
  if (!known) return;
  for (std::size_t i = 0; i < size_; ++i) {
    const double deviation_us = kPriorDeviation * (coefficient_us_[i] + 1.0);
    covariance_[i][i] = std::min(covariance_[i][i], deviation_us * deviation_us);
  }
}

void LinearForecast::set_initial_variance(double share) {
  for (std::size_t i = 0; i < size_; ++i) {
    // A coefficient that another run learned as 0 may be positive here.
    const double deviation_us = share * (std::max(coefficient_us_[i], 0.1 * prior_us_[i]) + 1.0);
    widest_[i] = covariance_[i][i] = deviation_us * deviation_us;
  }
}

std::optional<std::size_t> LinearForecast::index_of(std::string_view name) const {
  for (std::size_t i = 0; i < size_; ++i) {
    if (name_[i] == name) return i;
  }
  return std::nullopt;
}

bool LinearForecast::accepts(std::span<const double> values) const {
  return values.size() == size_ &&
         std::all_of(values.begin(), values.end(), [](double x) { return x >= 0 && x <= kMostValue; });
}

Nanoseconds LinearForecast::forecast(std::span<const double> values) const {
  if (!accepts(values)) return Nanoseconds::max();
  double us = 0;
  for (std::size_t i = 0; i < size_; ++i) us += coefficient_us_[i] * values[i];
  return Nanoseconds(static_cast<std::int64_t>(std::clamp(us, 1.0, kMostUs) * 1e3));
}

bool LinearForecast::learn(std::span<const double> values, Nanoseconds actual) {
  if (size_ == 0 || actual.count() < 0 || !accepts(values)) return false;
  const double actual_us = static_cast<double>(actual.count()) * 1e-3;
  Row px{};
  double xpx = 0;
  double forecast_us = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t j = 0; j < size_; ++j) px[i] += covariance_[i][j] * values[j];
    xpx += values[i] * px[i];
    forecast_us += coefficient_us_[i] * values[i];
  }
  // A frame ten times off the forecast was disturbed and is not informative, so its influence is bounded.
  const double bound_us = 2.0 * std::max(forecast_us, 10.0);
  const double residual_us = std::clamp(actual_us - forecast_us, -bound_us, bound_us);
  const double noise_us = kNoise * std::max(forecast_us, 10.0);
  const double denominator = noise_us * noise_us + xpx;
  for (std::size_t i = 0; i < size_; ++i) {
    coefficient_us_[i] += px[i] / denominator * residual_us;
    for (std::size_t j = 0; j < size_; ++j) covariance_[i][j] -= px[i] * px[j] / denominator;
  }
  bound();
  widen();
  return true;
}

// No work has a negative cost: a negative coefficient would cancel the reserve of other counts. It becomes 0, and the
// others what they are likely to be then, by the covariance: of counts that vary together only the sum of their costs
// is known, and that stays. Were it only cut off, what the others have gained on its account would stay with them, and
// the forecast would grow with each frame that took less time than it (the nearest point within the bounds, Simon 2010,
// one bound after another).
void LinearForecast::bound() {
  std::array<Row, kMostFeatures> left = covariance_;
  for (std::size_t bounds = 0; bounds < size_; ++bounds) {
    const auto end = coefficient_us_.begin() + static_cast<std::ptrdiff_t>(size_);
    const auto least = std::min_element(coefficient_us_.begin(), end);
    if (*least >= 0) return;
    const auto k = static_cast<std::size_t>(least - coefficient_us_.begin());
    const double below_us = std::exchange(coefficient_us_[k], 0.0);
    const Row with = left[k];
    if (!(with[k] > 0)) continue;
    for (std::size_t i = 0; i < size_; ++i) {
      if (i != k) coefficient_us_[i] -= with[i] / with[k] * below_us;
      for (std::size_t j = 0; j < size_; ++j) left[i][j] -= with[i] * with[j] / with[k];
    }
    // What is at its bound stays there, whatever becomes of the others.
    for (std::size_t i = 0; i < size_; ++i) left[i][k] = left[k][i] = 0;
  }
  for (std::size_t i = 0; i < size_; ++i) coefficient_us_[i] = std::max(coefficient_us_[i], 0.0);
}

// Adds the drift of one frame to every variance, up to its first value.
void LinearForecast::widen() {
  for (std::size_t i = 0; i < size_; ++i) {
    const double drift_us = kDrift * (std::abs(coefficient_us_[i]) + 1.0);
    covariance_[i][i] += drift_us * drift_us;
    if (covariance_[i][i] <= widest_[i]) continue;
    const double scale = std::sqrt(widest_[i] / covariance_[i][i]);
    for (std::size_t j = 0; j < size_; ++j) {
      covariance_[i][j] *= scale;
      covariance_[j][i] *= scale;
    }
  }
}

}  // namespace poise::scheduler
