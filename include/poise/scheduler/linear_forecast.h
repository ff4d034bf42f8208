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
  std::string_view name;  ///< not empty, and unique in the forecast; copied
  double prior_us = 0;    ///< coefficient before anything is learned, microseconds per unit of the feature, in [0, 1e9]
};

/// Forecast of a duration that is linear in features of the caller's choice. Its coefficients are tracked online as a
/// random walk (Kalman 1960; recursive least squares with forgetting is a special case, which stops learning if the
/// work never varies). A feature whose value is always 1 is the constant part. Features work best if their usual values
/// are near one: count in thousands where there are thousands.
///
/// Invariant: no coefficient is negative, so more work never takes less time; the covariance stays between the drift of
/// one frame and its first value. A plain value without a clock; one thread at a time.
class LinearForecast {
 public:
  static constexpr std::size_t kMostFeatures = 16;
  static constexpr double kMostValue = 1e12;  ///< of a feature's value

  /// No features: forecasts the smallest duration, and learns nothing.
  LinearForecast() = default;
  /// `features` must have no problem (first_problem); otherwise the forecast has none. `learned_us` are coefficients of
  /// an earlier run on the same machine, in the same order. They are used if there are as many as features and each is
  /// finite and >= 0.
  explicit LinearForecast(std::span<const ForecastFeature> features, std::span<const double> learned_us = {});
  /// The first broken rule: between one and kMostFeatures features, unique names, each prior in its range.
  static std::optional<Problem> first_problem(std::span<const ForecastFeature> features);

  [[nodiscard]] std::size_t size() const { return size_; }
  /// Name of feature `i` < size().
  [[nodiscard]] std::string_view name(std::size_t i) const { return name_[i]; }
  /// Index of the feature with this name, if there is one.
  [[nodiscard]] std::optional<std::size_t> index_of(std::string_view name) const;
  /// The current coefficients, in microseconds per unit of each feature; valid while this object lives.
  [[nodiscard]] std::span<const double> coefficients_us() const { return std::span(coefficient_us_).first(size_); }

  /// At least a microsecond. `values`: one a feature, each in [0, kMostValue]. Otherwise returns the longest duration,
  /// so that no work is planned on it.
  [[nodiscard]] Nanoseconds forecast(std::span<const double> values) const;
  /// Learns from one frame: the features' values and the measured duration (>= 0). Returns false, with nothing learned,
  /// if the values are invalid for forecast().
  bool learn(std::span<const double> values, Nanoseconds actual);

 private:
  using Row = std::array<double, kMostFeatures>;
  [[nodiscard]] bool accepts(std::span<const double> values) const;
  void set_initial_variance(double share);
  void bound();
  void widen();
  std::size_t size_ = 0;
  std::array<std::string, kMostFeatures> name_;
  Row prior_us_{};
  Row coefficient_us_{};
  Row widest_{};
  std::array<Row, kMostFeatures> covariance_{};
};

}  // namespace poise::scheduler
