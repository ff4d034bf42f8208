// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace poise::scheduler {

using Nanoseconds = std::chrono::nanoseconds;

/// Counted work of the tail: what comes after refinement.
struct TailWork {
  std::uint64_t bodies = 0;          ///< integrated
  std::uint64_t contacts = 0;        ///< pairs answered
  std::uint64_t candidate_pairs = 0; ///< gone through when contacts are gathered
  std::uint64_t sphere_contacts = 0; ///< answered one by one (0 for models with one impulse a pair)
};

/// Point forecast of the tail: linear in counted work, its coefficients followed online as a random walk (Kalman filter;
/// recursive least squares with forgetting is its special case, and stops learning where the work never varies).
/// Invariant: no coefficient is negative, so more work never takes less time; the covariance stays between the drift of one frame and what was unknown at first. No clock: the caller measures.
class TailForecast {
 public:
  TailForecast();
  /// Never negative.
  [[nodiscard]] Nanoseconds forecast(const TailWork& work) const;
  /// One frame's counted work and how long its tail took (>= 0).
  void learn(const TailWork& work, Nanoseconds actual);

 private:
  static constexpr std::size_t kFeatures = 5;
  using Features = std::array<double, kFeatures>;
  static Features features(const TailWork& work);
  void widen();
  Features coefficient_us_{};
  Features widest_{};
  std::array<Features, kFeatures> covariance_{};
};

/// A quantile of log(actual / forecast), tracked with no assumption on the noise: each observation moves it up by
/// eta (1 - alpha) when it was exceeded and down by eta alpha when not. For ratios within [exp(kLow), exp(kHigh)] the share of
/// exceeded frames differs from alpha by at most (kHigh - kLow + eta) / (eta T) after T frames (same family as adaptive
/// conformal inference, Gibbs and Candes 2021).
class TrackedQuantile {
 public:
  static constexpr double kLow = -1.3862943611198906;   ///< log(1/4); ratios beyond the clip are counted
  static constexpr double kHigh = 2.0794415416798357;   ///< log(8)

  explicit TrackedQuantile(double alpha = 0.01, double eta = 0.05, double start = 0.4);
  /// exp(q), by which a forecast is multiplied to make a reserve; positive.
  [[nodiscard]] double factor() const;
  [[nodiscard]] double log_quantile() const { return q_; }
  /// Observes one ratio actual / forecast; both > 0, else it is ignored.
  void observe(Nanoseconds actual, Nanoseconds forecast);
  [[nodiscard]] std::uint64_t beyond_clip() const { return beyond_clip_; }
  [[nodiscard]] std::uint64_t exceeded() const { return exceeded_; }
  [[nodiscard]] std::uint64_t observed() const { return observed_; }

 private:
  double alpha_;
  double eta_;
  double q_;
  std::uint64_t beyond_clip_ = 0;
  std::uint64_t exceeded_ = 0;
  std::uint64_t observed_ = 0;
};

/// Expected duration that follows what is reported: an exponential mean, times a tracked quantile. For host work.
class DurationForecast {
 public:
  /// 0 before anything was reported.
  [[nodiscard]] Nanoseconds reserve() const;
  void learn(Nanoseconds actual);

 private:
  double mean_ns_ = 0;
  bool started_ = false;
  TrackedQuantile margin_;
};

}  // namespace poise::scheduler
