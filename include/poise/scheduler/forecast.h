// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "poise/scheduler/linear_forecast.h"

namespace poise::scheduler {

/// Counted work of the tail, which is the part of a step after refinement.
struct TailWork {
  std::uint64_t bodies = 0;           ///< that are integrated
  std::uint64_t contacts = 0;         ///< pairs that the solver processes
  std::uint64_t candidate_pairs = 0;  ///< that are read when contacts are gathered
  std::uint64_t sphere_contacts = 0;  ///< solved one by one (0 for models with one impulse a pair)
  /// Of contact points in the contact solver, over all substeps: before the tail the expected number, after it the
  /// actual one.
  std::uint64_t point_iterations = 0;
  std::uint64_t coarse_contacts = 0;  ///< pairs whose coarsest contact is still missing when refinement begins
  std::uint64_t held_pairs = 0;  ///< pairs whose bodies wait in this frame; no other count has them or their bodies
  std::uint64_t held_found = 0;  ///< of these, that refinement finds contact points of: before it, the expected number
};

/// Point forecast of Poise's tail: a LinearForecast whose features are a constant and the counts of TailWork, in
/// thousands. One thread at a time.
class TailForecast {
 public:
  static constexpr std::size_t kFeatures = 9;         ///< a constant and the counts of TailWork, in its order
  static constexpr std::size_t kContacts = 2;         ///< index of TailWork::contacts
  static constexpr std::size_t kCandidatePairs = 3;   ///< index of TailWork::candidate_pairs
  static constexpr std::size_t kPointIterations = 5;  ///< index of TailWork::point_iterations
  static constexpr std::size_t kCoarseContacts = 6;   ///< index of TailWork::coarse_contacts
  using Features = std::array<double, kFeatures>;

  TailForecast();
  /// Begins with the coefficients of an earlier run on the same machine: microseconds for the constant, then
  /// microseconds per thousand of each count of TailWork, in its order. If one of them is negative or not
  /// finite, the priors are used for all.
  explicit TailForecast(const Features& coefficients_us);
  /// The learned coefficients, in the units of the constructor.
  [[nodiscard]] Features coefficients_us() const;
  /// Point forecast for this work; never negative.
  [[nodiscard]] Nanoseconds forecast(const TailWork& work) const;
  /// Learns from one frame: its counted work and the duration of its tail (>= 0).
  void learn(const TailWork& work, Nanoseconds actual);

  /// The names of the features and their coefficients before anything is learned.
  static std::span<const ForecastFeature> features();
  /// The features' values for this work.
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

  /// `alpha`: share of frames that may take longer than their reserve, in [1e-6, 0.5]. `eta`: step of the tracker, in
  /// [1e-6, 1]. `start`: first value of q, in [kLow, kHigh]. Values outside are clamped, NaN to the
  /// lower end.
  explicit TrackedQuantile(double alpha = kDefaultAlpha, double eta = kDefaultEta, double start = 0.4);
  static constexpr double kDefaultAlpha = 0.01;
  static constexpr double kDefaultEta = 0.05;
  /// The step `eta` for ratios with this spread: half the spread, clamped to [0.01, 0.2]. Chosen: a larger step forgets
  /// a burst sooner, a smaller one wastes less reserve; docs/scheduling.md.
  static double eta_for(double spread);
  [[nodiscard]] double alpha() const { return alpha_; }
  [[nodiscard]] double eta() const { return eta_; }
  /// Mean absolute deviation of log(actual / forecast), over about the last two hundred frames; 0 before the second
  /// one.
  [[nodiscard]] double spread() const { return spread_; }
  /// exp(q) > 0. A forecast times this factor is a reserve.
  [[nodiscard]] double factor() const;
  [[nodiscard]] double log_quantile() const { return q_; }
  /// Observes one ratio actual / forecast. Ignored unless both are > 0.
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

/// Whether a ratio actual / forecast is outside the range for which the bound of TrackedQuantile holds. True also if
/// one of the two is not positive.
bool beyond_clip(Nanoseconds actual, Nanoseconds forecast);

/// The learned state of a run's time forecasts, for the next run on the same machine.
struct TimePriors {
  TailForecast::Features tail_us{};  ///< TailForecast::coefficients_us
  TailForecast::Features head_us{};  ///< the same for the part before refinement
  double log_quantile = 0.4;         ///< TrackedQuantile::log_quantile
  double spread = 0;                 ///< TrackedQuantile::spread; 0: unknown
  double unit_cost_ns = 0;           ///< of a node-pair expansion, nanoseconds; 0: unknown
  std::uint64_t frames = 0;          ///< number that they were learned from; 0: nothing learned
};

/// Expected duration of the host's work: an exponential mean of the reported durations, times a tracked quantile.
class DurationForecast {
 public:
  explicit DurationForecast(double alpha = TrackedQuantile::kDefaultAlpha) : margin_(alpha) {}
  /// Duration to reserve; 0 before anything was reported.
  [[nodiscard]] Nanoseconds reserve() const;
  void learn(Nanoseconds actual);

 private:
  double mean_ns_ = 0;
  bool started_ = false;
  TrackedQuantile margin_;
};

}  // namespace poise::scheduler
