// SPDX-License-Identifier: MIT
#include "scene/compare/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace poise::io {
namespace {

double mean_of(const std::vector<double>& values) {
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// The frames that each draw takes, the same for all policies and budgets, so that differences are paired.
class Bootstrap {
 public:
  Bootstrap(std::size_t frames, std::uint64_t seed) : frames_(frames) {
    std::mt19937_64 bits(seed);
    drawn_.reserve(frames * kBootstrapDraws);
    // The distributions of the standard library differ from one library to the next.
    for (std::size_t i = 0; i < frames * kBootstrapDraws; ++i)
      drawn_.push_back(static_cast<std::uint32_t>(bits() % frames));
  }
  [[nodiscard]] Estimate of(const std::vector<double>& values) const {
    Estimate estimate{mean_of(values), {}, {}};
    if (values.size() < 2) return estimate;
    std::vector<double> means(kBootstrapDraws);
    for (std::size_t draw = 0; draw < means.size(); ++draw) {
      double sum = 0;
      for (std::size_t i = 0; i < frames_; ++i) sum += values[drawn_[draw * frames_ + i]];
      means[draw] = sum / static_cast<double>(frames_);
    }
    std::sort(means.begin(), means.end());
    constexpr double kTail = 0.025;
    const auto last = static_cast<double>(means.size() - 1);
    estimate.low = means[static_cast<std::size_t>(kTail * last)];
    estimate.high = means[static_cast<std::size_t>((1 - kTail) * last + 0.5)];
    return estimate;
  }

 private:
  std::size_t frames_;
  std::vector<std::uint32_t> drawn_;
};

// The frames in which each step is defined and has a reference that has converged.
std::vector<std::size_t> frames_that_count(const ComparedSteps& steps, PolicyComparison& result) {
  std::vector<std::size_t> frames;
  const std::size_t each = steps.policies.size() * steps.budgets.size();
  for (std::size_t frame = 0; frame < steps.frames(); ++frame) {
    const auto begin = steps.steps.begin() + static_cast<std::ptrdiff_t>(frame * each);
    const auto end = begin + static_cast<std::ptrdiff_t>(each);
    if (!std::all_of(begin, end, [](const ComparedStep& step) { return step.converged; })) {
      ++result.not_converged;
    } else if (!std::all_of(begin, end, [](const ComparedStep& s) { return s.e_mps && s.e_rel && s.e_seen_mps; })) {
      ++result.undefined;
    } else {
      frames.push_back(frame);
    }
  }
  return frames;
}

// The mean height of a curve over the budgets.
double height(const std::vector<double>& budgets, const std::vector<double>& values) {
  if (budgets.size() == 1) return values.front();
  double area = 0;
  for (std::size_t i = 1; i < budgets.size(); ++i)
    area += 0.5 * (values[i] + values[i - 1]) * (budgets[i] - budgets[i - 1]);
  return area / (budgets.back() - budgets.front());
}

ComparisonRow row_of(const ComparedSteps& steps, const std::vector<std::size_t>& frames, std::size_t policy,
                     std::size_t budget, const Bootstrap& bootstrap) {
  const auto mean = [&](auto&& value) {
    std::vector<double> values;
    for (const std::size_t frame : frames) {
      if (const std::optional<double> one = value(steps.at(frame, policy, budget))) values.push_back(*one);
    }
    return values.empty() ? std::optional<double>() : std::optional(mean_of(values));
  };
  ComparisonRow row;
  row.policy = steps.policies[policy];
  row.budget = steps.budgets[budget];
  const auto estimate = [&](std::optional<double> ComparedStep::*figure) {
    std::vector<double> values;
    for (const std::size_t frame : frames) values.push_back(*(steps.at(frame, policy, budget).*figure));
    return bootstrap.of(values);
  };
  row.e_seen_mps = estimate(&ComparedStep::e_seen_mps);
  row.e_mps = estimate(&ComparedStep::e_mps);
  row.e_rel = estimate(&ComparedStep::e_rel);
  row.gap_mean_px = mean([](const ComparedStep& s) { return s.gap_mean_px; });
  row.false_rate = mean([](const ComparedStep& s) { return s.false_rate; });
  row.work_units = mean([](const ComparedStep& s) { return std::optional(s.work_units); }).value_or(0);
  row.time_ms = mean([](const ComparedStep& s) { return std::optional(s.time_ms); }).value_or(0);
  return row;
}

std::string conclusion_of(PolicyComparison& result, const std::vector<std::vector<double>>& heights,
                          const Bootstrap& bootstrap) {
  std::vector<std::size_t> ranked;
  for (std::size_t p = 0; p < result.areas.size(); ++p) {
    if (result.areas[p].policy != kOraclePolicy) ranked.push_back(p);
  }
  if (ranked.empty()) return "only the oracle took part";
  const auto mean = [&](std::size_t p) { return result.areas[p].e_seen_mps.mean; };
  std::stable_sort(ranked.begin(), ranked.end(), [&](std::size_t a, std::size_t b) { return mean(a) < mean(b); });
  const std::size_t best = ranked[0];
  result.best = result.areas[best].policy;
  const std::string first = fmt::format("{}: mean E_seen {:.3g} m/s over the budgets", result.areas[best].policy,
                                        result.areas[best].e_seen_mps.mean);
  if (ranked.size() == 1) return first;
  const std::size_t next = ranked[1];
  std::vector<double> less;
  for (std::size_t i = 0; i < heights[best].size(); ++i) less.push_back(heights[next][i] - heights[best][i]);
  const Estimate by = bootstrap.of(less);
  result.next = result.areas[next].policy;
  result.too_few = result.frames < kLeastFramesToConclude;
  result.sure = !result.too_few && by.low && *by.low > 0;
  const double per = mean(next) > 0 ? 100 / mean(next) : 0;
  const std::string interval =
      by.low && by.high ? fmt::format("95 % interval {:.1f} to {:.1f} %, ", per * *by.low, per * *by.high) : "";
  return fmt::format("{}, {:.1f} % below {} ({}{} {}): {}", first, per * by.mean, result.next, interval, result.frames,
                     result.frames == 1 ? "frame" : "frames",
                     result.too_few ? "too few states"
                     : result.sure  ? "sure"
                                    : "the two cannot be told apart");
}

}  // namespace

PolicyComparison compare_steps(const ComparedSteps& steps, std::uint64_t seed) {
  PolicyComparison result;
  result.budgets = steps.budgets;
  const std::vector<std::size_t> frames = frames_that_count(steps, result);
  result.frames = frames.size();
  if (frames.empty()) {
    result.conclusion = "no frame could be compared";
    return result;
  }
  const Bootstrap bootstrap(frames.size(), seed);
  std::vector<std::vector<double>> heights(steps.policies.size());
  for (std::size_t p = 0; p < steps.policies.size(); ++p) {
    for (std::size_t b = 0; b < steps.budgets.size(); ++b)
      result.rows.push_back(row_of(steps, frames, p, b, bootstrap));
    for (const std::size_t frame : frames) {
      std::vector<double> curve;
      for (std::size_t b = 0; b < steps.budgets.size(); ++b) curve.push_back(*steps.at(frame, p, b).e_seen_mps);
      heights[p].push_back(height(steps.budgets, curve));
    }
    result.areas.push_back({steps.policies[p], bootstrap.of(heights[p]), {}});
  }
  const auto oracle = std::find(steps.policies.begin(), steps.policies.end(), kOraclePolicy);
  if (oracle != steps.policies.end()) {
    const auto o = static_cast<std::size_t>(oracle - steps.policies.begin());
    for (std::size_t p = 0; p < steps.policies.size(); ++p) {
      result.areas[p].regret_mps = result.areas[p].e_seen_mps.mean - result.areas[o].e_seen_mps.mean;
      for (std::size_t b = 0; b < steps.budgets.size(); ++b) {
        const auto mean = [&](std::size_t which) {
          return result.rows[which * steps.budgets.size() + b].e_seen_mps.mean;
        };
        result.rows[p * steps.budgets.size() + b].regret_mps = mean(p) - mean(o);
      }
    }
  }
  result.conclusion = conclusion_of(result, heights, bootstrap);
  return result;
}

}  // namespace poise::io
