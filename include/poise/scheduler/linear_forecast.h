// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "poise/scheduler/problem.h"

namespace poise::scheduler {

using Nanoseconds = std::chrono::nanoseconds;

/// One counted quantity that a duration depends on.
struct ForecastFeature {
  std::string_view name;  ///< not empty, unlike the names of the others; copied
  double prior_us = 0;    ///< thought cost of one of it before anything is learned, microseconds, in [0, 1e9]
};

/// Forecast of a duration that is linear in features of the caller's choosing, its coefficients followed online as a
/// random walk (Kalman 1960; recursive least squares with forgetting is its special case, and stops learning where the
/// work never varies). A feature whose value is always 1 is the constant part. Features work best when their usual
/// values are near one: count in thousands where there are thousands.
///
/// Invariant: no coefficient is negative, so more work never takes less time; the covariance stays between the drift of
/// one frame and what was unknown at first. A plain value without a clock; one thread at a time.
class LinearForecast {
 public:
  static constexpr std::size_t kMostFeatures = 16;
  static constexpr double kMostValue = 1e12;  ///< of a feature

  /// No feature: forecasts the least there is, and learns nothing.
  LinearForecast() = default;
  /// Features without a problem; else it has none. `learned_us` are coefficients that another run on the same machine
  /// came to, in the same order; they are used where there are as many as features and each is in [0, 1e9].
  explicit LinearForecast(std::span<const ForecastFeature> features, std::span<const double> learned_us = {});
  /// Between one and kMostFeatures of them, each with a name of its own and a prior in its range?
  static std::optional<Problem> first_problem(std::span<const ForecastFeature> features);

  [[nodiscard]] std::size_t size() const { return size_; }
  /// Name of feature `i` < size().
  [[nodiscard]] std::string_view name(std::size_t i) const { return name_[i]; }
  [[nodiscard]] std::optional<std::size_t> index_of(std::string_view name) const;
  /// What they have come to, in microseconds a unit of each feature; valid while this lives.
  [[nodiscard]] std::span<const double> coefficients_us() const { return std::span(coefficient_us_).first(size_); }

  /// At least a microsecond. One value a feature, each in [0, kMostValue]; else the longest duration there is, so that
  /// nothing is promised on it.
  [[nodiscard]] Nanoseconds forecast(std::span<const double> values) const;
  /// One frame's values and how long it took (>= 0). False: nothing learned, the values are none that may be forecast.
  bool learn(std::span<const double> values, Nanoseconds actual);

 private:
  using Row = std::array<double, kMostFeatures>;
  [[nodiscard]] bool accepts(std::span<const double> values) const;
  void set_ignorance(double share);
  void widen();
  std::size_t size_ = 0;
  std::array<std::string, kMostFeatures> name_;
  Row prior_us_{};
  Row coefficient_us_{};
  Row widest_{};
  std::array<Row, kMostFeatures> covariance_{};
};

}  // namespace poise::scheduler
