// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "poise/scheduler/linear_forecast.h"

namespace poise::scheduler {

/// Counted work of the tail: what comes after refinement.
struct TailWork {
  std::uint64_t bodies = 0;           ///< integrated
  std::uint64_t contacts = 0;         ///< pairs answered
  std::uint64_t candidate_pairs = 0;  ///< gone through when contacts are gathered
  std::uint64_t sphere_contacts = 0;  ///< answered one by one (0 for models with one impulse a pair)
  std::uint64_t point_iterations =
      0;  ///< of places by resting contact, in all substeps: before the tail those that are likely, after it those made
  std::uint64_t coarse_contacts = 0;  ///< pairs whose coarsest contact is still to be made when refinement begins
};

/// Point forecast of Poise's tail: a LinearForecast whose features are one and the counts of TailWork, in thousands.
class TailForecast {
 public:
  static constexpr std::size_t kFeatures = 7;         ///< one and the counts of TailWork, in its order
  static constexpr std::size_t kContacts = 2;         ///< place of TailWork::contacts
  static constexpr std::size_t kPointIterations = 5;  ///< place of TailWork::point_iterations; in nanoseconds each
  static constexpr std::size_t kCoarseContacts = 6;   ///< likewise of TailWork::coarse_contacts
  using Features = std::array<double, kFeatures>;

  TailForecast();
  /// Begins from what another run on the same machine came to: microseconds, and microseconds per thousand of each
  /// count of TailWork in its order. One that is negative or not finite counts as not known.
  explicit TailForecast(const Features& coefficients_us);
  /// What it has come to.
  [[nodiscard]] Features coefficients_us() const;
  /// Never negative.
  [[nodiscard]] Nanoseconds forecast(const TailWork& work) const;
  /// One frame's counted work and how long its tail took (>= 0).
  void learn(const TailWork& work, Nanoseconds actual);

  /// The names of the features and what is thought of them before anything is learned.
  static std::span<const ForecastFeature> features();
  /// Their values for this work.
  static Features values(const TailWork& work);
  [[nodiscard]] const LinearForecast& linear() const { return linear_; }

 private:
  LinearForecast linear_;
};

/// A quantile of log(actual / forecast), tracked with no assumption on the noise: each observation moves it up by
/// eta (1 - alpha) when it was exceeded and down by eta alpha when not. For ratios within [exp(kLow), exp(kHigh)] the
/// share of exceeded frames differs from alpha by at most (kHigh - kLow + eta) / (eta T) after T frames (same family as
/// adaptive conformal inference, Gibbs and Candes 2021).
class TrackedQuantile {
 public:
  static constexpr double kLow = -1.3862943611198906;  ///< log(1/4); ratios beyond the clip are counted
  static constexpr double kHigh = 2.0794415416798357;  ///< log(8)

  /// The share of frames that may take longer than their reserve, in [1e-6, 0.5]; the step, in [1e-6, 1]; where q
  /// begins, in [kLow, kHigh]. What is outside is moved to the nearest end.
  explicit TrackedQuantile(double alpha = kDefaultAlpha, double eta = kDefaultEta, double start = 0.4);
  static constexpr double kDefaultAlpha = 0.01;
  static constexpr double kDefaultEta = 0.05;
  /// The step for ratios that spread like this: half the mean distance of log(actual / forecast) from its mean, within
  /// [0.01, 0.2]. Chosen: a larger step forgets a burst sooner, a smaller one wastes less reserve; docs/scheduling.md.
  static double eta_for(double spread);
  [[nodiscard]] double alpha() const { return alpha_; }
  [[nodiscard]] double eta() const { return eta_; }
  /// Mean distance of log(actual / forecast) from its mean, over about the last two hundred frames; 0 before the second
  /// one.
  [[nodiscard]] double spread() const { return spread_; }
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
  double mean_ = 0;
  double spread_ = 0;
  std::uint64_t beyond_clip_ = 0;
  std::uint64_t exceeded_ = 0;
  std::uint64_t observed_ = 0;
};

/// Is a ratio actual / forecast outside what the bound of TrackedQuantile speaks of? Also if one of the two is not
/// positive.
bool beyond_clip(Nanoseconds actual, Nanoseconds forecast);

/// What the time forecasts of a run came to, for the next run on the same machine.
struct TimePriors {
  TailForecast::Features tail_us{};  ///< TailForecast::coefficients_us
  TailForecast::Features head_us{};  ///< the same of the part before refinement
  double log_quantile = 0.4;         ///< TrackedQuantile::log_quantile
  double spread = 0;                 ///< TrackedQuantile::spread; 0: not known
  double unit_cost_ns = 0;           ///< of a node-pair expansion; 0: not known
  std::uint64_t frames = 0;          ///< that they were learned from; 0: there are none
};

/// Expected duration that follows what is reported: an exponential mean, times a tracked quantile. For host work.
class DurationForecast {
 public:
  explicit DurationForecast(double alpha = TrackedQuantile::kDefaultAlpha) : margin_(alpha) {}
  /// 0 before anything was reported.
  [[nodiscard]] Nanoseconds reserve() const;
  void learn(Nanoseconds actual);

 private:
  double mean_ns_ = 0;
  bool started_ = false;
  TrackedQuantile margin_;
};

}  // namespace poise::scheduler
