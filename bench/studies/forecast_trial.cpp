// SPDX-License-Identifier: MIT
#include "studies/forecast_trial.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace poise::simulation {
namespace {

constexpr std::size_t kWindow = 200;
// Largest share of the tail's time that may be missing in an undisturbed frame, because of the resolution of the
// clocks. Chosen.
constexpr double kDisturbed = 0.03;

double ns_of(Nanoseconds time) { return static_cast<double>(time.count()); }

/// Returns the reserve of a frame, then learns from its actual duration.
struct Method {
  std::string name;
  std::function<double(const RecordedTail&)> reserve_ns;
  std::function<void(const RecordedTail&)> learn;
};

struct Tracker {
  scheduler::TailForecast tail;
  scheduler::TrackedQuantile margin;

  [[nodiscard]] Nanoseconds point(const RecordedTail& frame) const { return tail.forecast(frame.forecast_for); }
  void learn(const RecordedTail& frame) {
    margin.observe(frame.actual, point(frame));
    scheduler::TailWork work = frame.forecast_for;
    work.contacts = frame.contacts;
    tail.learn(work, frame.actual);
  }
};

struct Moments {
  double count = 0, mean = 0, squares = 0;
  // Running mean and variance (Welford 1962).
  void add(double value) {
    ++count;
    const double off = value - mean;
    mean += off / count;
    squares += off * (value - mean);
  }
  [[nodiscard]] double deviation() const { return count > 1 ? std::sqrt(squares / (count - 1)) : 0; }
};

ForecastScore score_of(const Method& method, std::span<const RecordedTail> tails, double alpha, std::size_t skip) {
  ForecastScore score;
  score.method = method.name;
  double frames = 0;
  double reserved_ns = 0;
  double needed_ns = 0;
  double loss_ns = 0;
  for (std::size_t i = 0; i < tails.size(); ++i) {
    const double reserve_ns = method.reserve_ns(tails[i]);
    const double actual_ns = ns_of(tails[i].actual);
    if (i >= skip) {
      ++frames;
      reserved_ns += reserve_ns;
      needed_ns += actual_ns;
      if (actual_ns > reserve_ns) ++score.exceeded;
      loss_ns += actual_ns > reserve_ns ? (1 - alpha) * (actual_ns - reserve_ns) : alpha * (reserve_ns - actual_ns);
    }
    method.learn(tails[i]);
  }
  if (frames == 0 || needed_ns <= 0) return score;
  score.exceeded /= frames;
  score.reserve_over_actual = reserved_ns / needed_ns;
  score.pinball = loss_ns / needed_ns;
  return score;
}

Method tracked(const std::string& name, Tracker& tracker) {
  return {name, [&tracker](const RecordedTail& frame) { return ns_of(tracker.point(frame)) * tracker.margin.factor(); },
          [&tracker](const RecordedTail& frame) { tracker.learn(frame); }};
}

}  // namespace

std::vector<RecordedTail> recorded_tails(std::span<const RunFrame> frames, bool undisturbed) {
  std::vector<RecordedTail> tails;
  for (const RunFrame& frame : frames) {
    const FrameReport& r = frame.report;
    if (frame.warm_up || r.tail_needed().count() <= 0) continue;
    if (undisturbed && ns_of(r.off_cpu) > kDisturbed * ns_of(r.tail_actual)) continue;
    tails.push_back({r.tail_work, r.contact_pairs, r.tail_needed()});
  }
  return tails;
}

std::vector<ForecastScore> try_forecasts(std::span<const RecordedTail> tails, double alpha, std::size_t skip) {
  std::vector<ForecastScore> scores;
  Tracker ours{{}, scheduler::TrackedQuantile(alpha)};
  scores.push_back(score_of(tracked("tracked quantile of a linear forecast", ours), tails, alpha, skip));
  scores.back().beyond_clip = ours.margin.beyond_clip();
  Tracker bare{{}, scheduler::TrackedQuantile(alpha)};
  scores.push_back(
      score_of({"linear forecast, no margin", [&](const RecordedTail& frame) { return ns_of(bare.point(frame)); },
                [&](const RecordedTail& frame) { bare.learn(frame); }},
               tails, alpha, skip));
  for (const double deviations : {0.0, 3.0}) {
    Moments moments;
    scores.push_back(score_of({deviations > 0 ? "mean + 3 sigma" : "mean",
                               [&](const RecordedTail&) { return moments.mean + deviations * moments.deviation(); },
                               [&](const RecordedTail& frame) { moments.add(ns_of(frame.actual)); }},
                              tails, alpha, skip));
  }
  std::vector<double> window;
  std::vector<double> sorted;
  const auto quantile = [&](const RecordedTail&) {
    if (window.empty()) return 0.0;
    sorted = window;
    const auto rank = static_cast<std::size_t>(std::ceil((1 - alpha) * static_cast<double>(sorted.size())));
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(rank, 1, sorted.size()) - 1);
    std::nth_element(sorted.begin(), at, sorted.end());
    return *at;
  };
  scores.push_back(score_of({"quantile of the last 200", quantile,
                             [&](const RecordedTail& frame) {
                               window.push_back(ns_of(frame.actual));
                               if (window.size() > kWindow) window.erase(window.begin());
                             }},
                            tails, alpha, skip));
  return scores;
}

}  // namespace poise::simulation
