// SPDX-License-Identifier: MIT
#include "poise/scheduler/forecast.h"

#include <algorithm>
#include <cmath>

namespace poise::scheduler {
namespace {

// How much a coefficient is thought to wander from frame to frame and one frame to be off, each as a share. Chosen: a
// machine that changes its speed is followed within about ten frames.
constexpr double kDrift = 0.02;
constexpr double kNoise = 0.1;
// Standard deviation of a coefficient of which nothing is known, as a share of its prior and of 1 us.
constexpr double kIgnorance = 3.0;
// Prior: 30 us, and per thousand: bodies 100 us, contacts 300 us, candidates 20 us, sphere contacts 100 us, patch
// visits 30 us, coarse contacts 100 us. On the slow side of the machines that we tried; the first tens of frames
// replace it.
constexpr TailForecast::Features kPriorUs = {30.0, 100.0, 300.0, 20.0, 100.0, 30.0, 100.0};
// The same of a coefficient that another run has learned. Chosen: scenes differ by about as much.
constexpr double kDoubt = 0.5;

}  // namespace

TailForecast::TailForecast() : coefficient_us_(kPriorUs) { set_ignorance(kIgnorance); }

TailForecast::TailForecast(const Features& coefficients_us) : coefficient_us_(kPriorUs) {
  const bool known = std::all_of(coefficients_us.begin(), coefficients_us.end(),
                                 [](double us) { return std::isfinite(us) && us >= 0; });
  if (known) coefficient_us_ = coefficients_us;
  set_ignorance(kIgnorance);
  if (!known) return;
  for (std::size_t i = 0; i < kFeatures; ++i) {
    const double deviation_us = kDoubt * (coefficient_us_[i] + 1.0);
    covariance_[i][i] = std::min(covariance_[i][i], deviation_us * deviation_us);
  }
}

void TailForecast::set_ignorance(double share) {
  for (std::size_t i = 0; i < kFeatures; ++i) {
    // A cost that another run found to be nothing may still be one here.
    const double deviation_us = share * (std::max(coefficient_us_[i], 0.1 * kPriorUs[i]) + 1.0);
    widest_[i] = covariance_[i][i] = deviation_us * deviation_us;
  }
}

TailForecast::Features TailForecast::features(const TailWork& work) {
  const auto thousands = [](std::uint64_t count) { return static_cast<double>(count) * 1e-3; };
  return {1.0,
          thousands(work.bodies),
          thousands(work.contacts),
          thousands(work.candidate_pairs),
          thousands(work.sphere_contacts),
          thousands(work.point_iterations),
          thousands(work.coarse_contacts)};
}

Nanoseconds TailForecast::forecast(const TailWork& work) const {
  const Features x = features(work);
  double us = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) us += coefficient_us_[i] * x[i];
  return Nanoseconds(static_cast<std::int64_t>(std::max(us, 1.0) * 1e3));
}

void TailForecast::learn(const TailWork& work, Nanoseconds actual) {
  const Features x = features(work);
  const double actual_us = static_cast<double>(actual.count()) * 1e-3;
  Features px{};
  double xpx = 0;
  double forecast_us = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) {
    for (std::size_t j = 0; j < kFeatures; ++j) px[i] += covariance_[i][j] * x[j];
    xpx += x[i] * px[i];
    forecast_us += coefficient_us_[i] * x[i];
  }
  // A frame ten times off the forecast was disturbed, not informative: its pull is bounded.
  const double bound_us = 2.0 * std::max(forecast_us, 10.0);
  const double residual_us = std::clamp(actual_us - forecast_us, -bound_us, bound_us);
  const double noise_us = kNoise * std::max(forecast_us, 10.0);
  const double denominator = noise_us * noise_us + xpx;
  for (std::size_t i = 0; i < kFeatures; ++i) {
    // No work has a negative cost; a fit that says so would make a reserve of nothing for other counts.
    coefficient_us_[i] = std::max(0.0, coefficient_us_[i] + px[i] / denominator * residual_us);
    for (std::size_t j = 0; j < kFeatures; ++j) covariance_[i][j] -= px[i] * px[j] / denominator;
  }
  widen();
}

// Every coefficient may have wandered since; none can be less known than before the first frame.
void TailForecast::widen() {
  for (std::size_t i = 0; i < kFeatures; ++i) {
    const double drift_us = kDrift * (std::abs(coefficient_us_[i]) + 1.0);
    covariance_[i][i] += drift_us * drift_us;
    if (covariance_[i][i] <= widest_[i]) continue;
    const double scale = std::sqrt(widest_[i] / covariance_[i][i]);
    for (std::size_t j = 0; j < kFeatures; ++j) {
      covariance_[i][j] *= scale;
      covariance_[j][i] *= scale;
    }
  }
}

TrackedQuantile::TrackedQuantile(double alpha, double eta, double start)
    : alpha_(std::clamp(alpha, 1e-6, 0.5)), eta_(std::clamp(eta, 1e-6, 1.0)), q_(std::clamp(start, kLow, kHigh)) {}

double TrackedQuantile::eta_for(double spread) {
  if (!(spread > 0)) return kDefaultEta;
  return std::clamp(0.5 * spread, 0.01, 0.2);
}

double TrackedQuantile::factor() const { return std::exp(q_); }

void TrackedQuantile::observe(Nanoseconds actual, Nanoseconds forecast) {
  if (actual.count() <= 0 || forecast.count() <= 0) return;
  const double raw = std::log(static_cast<double>(actual.count()) / static_cast<double>(forecast.count()));
  const double z = std::clamp(raw, kLow, kHigh);
  if (z != raw) ++beyond_clip_;
  constexpr double kMemory = 0.005;
  if (observed_ == 0) mean_ = z;
  const double share = std::max(kMemory, 1.0 / (1.0 + static_cast<double>(observed_)));
  mean_ += share * (z - mean_);
  spread_ += share * (std::abs(z - mean_) - spread_);
  ++observed_;
  const bool above = z > q_;
  if (above) ++exceeded_;
  q_ += eta_ * ((above ? 1.0 : 0.0) - alpha_);
}

bool beyond_clip(Nanoseconds actual, Nanoseconds forecast) {
  if (actual.count() <= 0 || forecast.count() <= 0) return true;
  const double z = std::log(static_cast<double>(actual.count()) / static_cast<double>(forecast.count()));
  return z < TrackedQuantile::kLow || z > TrackedQuantile::kHigh;
}

Nanoseconds DurationForecast::reserve() const {
  if (!started_) return Nanoseconds(0);
  return Nanoseconds(static_cast<std::int64_t>(mean_ns_ * margin_.factor()));
}

void DurationForecast::learn(Nanoseconds actual) {
  const double ns = static_cast<double>(std::max<std::int64_t>(actual.count(), 0));
  if (started_) {
    margin_.observe(actual, Nanoseconds(static_cast<std::int64_t>(mean_ns_)));
    mean_ns_ += 0.1 * (ns - mean_ns_);
  } else {
    mean_ns_ = ns;
    started_ = true;
  }
}

}  // namespace poise::scheduler
