// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// Policies compared on the same states: what each step was measured to be, and what follows of all of them together.
namespace poise::io {

/// One step of a policy with a budget, measured by the reference of its state. A figure that is undefined is empty.
struct ComparedStep {
  bool converged = false;  ///< the reference
  std::optional<double> e_mps, e_rel, e_seen_mps, gap_mean_px, false_rate;
  double work_units = 0;  ///< node-pair expansions of refinement
  double time_ms = 0;     ///< of the step
};

/// All steps of a comparison. Invariant: steps.size() is frames * policies * budgets; those of a frame follow each
/// other, in it those of a policy.
struct ComparedSteps {
  std::vector<std::string> policies;
  std::vector<double> budgets;  ///< ascending
  std::vector<ComparedStep> steps;

  [[nodiscard]] std::size_t frames() const {
    return policies.empty() || budgets.empty() ? 0 : steps.size() / (policies.size() * budgets.size());
  }
  [[nodiscard]] const ComparedStep& at(std::size_t frame, std::size_t policy, std::size_t budget) const {
    return steps[(frame * policies.size() + policy) * budgets.size() + budget];
  }
};

/// A mean over frames, with the 95 % interval of bootstrap over the frames (percentile method; Efron 1979). One frame
/// has no interval.
struct Estimate {
  double mean = 0;
  std::optional<double> low, high;
};

/// A policy at a budget: means over the frames that count.
struct ComparisonRow {
  std::string policy;
  double budget = 0;
  Estimate e_mps, e_rel, e_seen_mps;
  std::optional<double> regret_mps;  ///< mean E_seen less that of the oracle; empty where that was not compared
  std::optional<double> gap_mean_px, false_rate;  ///< over the frames in which they are defined
  double work_units = 0, time_ms = 0;
};

/// A policy over all budgets: the mean height of its curve of E_seen against the budget, by trapezoids.
struct ComparisonArea {
  std::string policy;
  Estimate e_seen_mps;
  std::optional<double> regret_mps;
};

/// The results of a comparison.
struct PolicyComparison {
  std::vector<double> budgets;
  std::size_t frames = 0;         ///< that count: for all policies and budgets
  std::size_t not_converged = 0;  ///< left out: a reference had not converged
  std::size_t undefined = 0;      ///< left out: nothing touched
  std::vector<ComparisonRow> rows;
  std::vector<ComparisonArea> areas;  ///< in the order of the policies
  std::string conclusion;             ///< one line: which policy, by how much, how sure
  std::string best, next;             ///< that policy and the one after it; empty where there is none
  bool too_few = false;               ///< fewer than kLeastFramesToConclude: nothing is concluded of the two
  bool sure = false;                  ///< whether the two can be told apart
};

/// The name of the policy that regret is measured from and that no conclusion is about.
inline constexpr const char* kOraclePolicy = "oracle";
/// Draws of the bootstrap. Chosen: the ends of an interval then vary by a few per cent of its width.
inline constexpr int kBootstrapDraws = 2000;
/// Fewer frames conclude nothing: where differences have one sign, their interval never holds 0, even of two frames.
/// The least number of which a sign test with two sides can be significant at 5 %: 2 / 2^6 = 0.03.
inline constexpr std::size_t kLeastFramesToConclude = 6;

/// Computes the results. `seed` is that of the bootstrap; the same arguments give the same bits.
PolicyComparison compare_steps(const ComparedSteps& steps, std::uint64_t seed);

}  // namespace poise::io
