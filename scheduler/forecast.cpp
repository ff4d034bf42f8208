// SPDX-License-Identifier: MIT
#include "poise/scheduler/forecast.h"

#include <algorithm>
#include <cmath>

#include "math/functions.h"

namespace poise::scheduler {
namespace {

// Prior: 30 us, and the following microseconds per thousand. Chosen on the slow side of the machines that we tried; the
// first tens of frames replace it.
constexpr std::array<ForecastFeature, TailForecast::kFeatures> kTailFeatures{{
    {"constant", 30.0},
    {"bodies", 100.0},
    {"contacts", 300.0},
    {"candidate_pairs", 20.0},
    {"sphere_contacts", 100.0},
    {"point_iterations", 30.0},
    {"coarse_contacts", 100.0},
    {"held_pairs", 20.0},
    {"held_found", 100.0},
}};

// Largest number of nanoseconds that a duration can hold safely.
constexpr double kMostNs = 9e18;

}  // namespace

TailForecast::TailForecast() : linear_(kTailFeatures) {}

TailForecast::TailForecast(const Features& coefficients_us) : linear_(kTailFeatures, coefficients_us) {}

std::span<const ForecastFeature> TailForecast::features() { return kTailFeatures; }

TailForecast::Features TailForecast::coefficients_us() const {
  Features coefficients{};
  std::copy_n(linear_.coefficients_us().begin(), kFeatures, coefficients.begin());
  return coefficients;
}

TailForecast::Features TailForecast::values(const TailWork& work) {
  const auto thousands = [](std::uint64_t count) { return static_cast<double>(count) * 1e-3; };
  return {1.0,
          thousands(work.bodies),
          thousands(work.contacts),
          thousands(work.candidate_pairs),
          thousands(work.sphere_contacts),
          thousands(work.point_iterations),
          thousands(work.coarse_contacts),
          thousands(work.held_pairs),
          thousands(work.held_found)};
}

Nanoseconds TailForecast::forecast(const TailWork& work) const { return linear_.forecast(values(work)); }

void TailForecast::learn(const TailWork& work, Nanoseconds actual) { linear_.learn(values(work), actual); }

namespace {

// A value that is no number becomes the lower end.
double clamped(double value, double low, double high) { return value > low ? std::min(value, high) : low; }

}  // namespace

TrackedQuantile::TrackedQuantile(double alpha, double eta, double start)
    : alpha_(clamped(alpha, 1e-6, 0.5)), eta_(clamped(eta, 1e-6, 1.0)), q_(clamped(start, kLow, kHigh)) {}

double TrackedQuantile::eta_for(double spread) {
  if (!(spread > 0)) return kDefaultEta;
  return std::clamp(0.5 * spread, 0.01, 0.2);
}

double TrackedQuantile::factor() const { return math::exp(q_); }

void TrackedQuantile::observe(Nanoseconds actual, Nanoseconds forecast) {
  if (actual.count() <= 0 || forecast.count() <= 0) return;
  const double raw = math::log(static_cast<double>(actual.count()) / static_cast<double>(forecast.count()));
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
  const double z = math::log(static_cast<double>(actual.count()) / static_cast<double>(forecast.count()));
  return z < TrackedQuantile::kLow || z > TrackedQuantile::kHigh;
}

Nanoseconds DurationForecast::reserve() const {
  if (!started_) return Nanoseconds(0);
  return Nanoseconds(static_cast<std::int64_t>(std::min(mean_ns_ * margin_.factor(), kMostNs)));
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
