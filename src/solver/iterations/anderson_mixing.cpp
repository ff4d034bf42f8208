// SPDX-License-Identifier: MIT
#include "solver/iterations/anderson_mixing.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>

#include "solver/iterations/mixing_lanes.h"

namespace poise::solver {
namespace {

// A residual that grows to this many times the square of the last one restarts the history.
constexpr double kGrown = 4;
// Regularises the small system where steps are nearly parallel, and keeps the next point near: internal stresses would
// else drift until a contact point slips.
constexpr double kRidge = 1e-6;

}  // namespace

void AndersonMixing::begin(std::size_t size) {
  size_ = size;
  count_ = next_ = 0;
  started_ = false;
  residual_.resize(std::max(residual_.size(), size));
  after_.resize(std::max(after_.size(), size));
  residual_steps_.resize(std::max(residual_steps_.size(), kDepth * size));
  for (std::vector<double>& step : after_steps_) step.resize(std::max(step.size(), size));
}

bool AndersonMixing::mix(std::span<const double> before, std::span<double> after) {
  const NotedStep noted = note_step(before.first(size_), after.first(size_), next_,
                                    {residual_, after_, residual_steps_, after_steps_[next_]});
  const bool learnt = started_ && noted.residual_square <= kGrown * last_square_;
  if (started_ && !learnt) count_ = 0;
  started_ = true;
  last_square_ = noted.residual_square;
  if (!learnt) return false;
  next_ = (next_ + 1) % kDepth;
  count_ = std::min(count_ + 1, kDepth);
  using Small =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, static_cast<int>(kDepth), static_cast<int>(kDepth)>;
  using Few = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, static_cast<int>(kDepth), 1>;
  const auto count = static_cast<Eigen::Index>(count_);
  const auto index = [&](std::size_t k) { return (next_ + kDepth - 1 - k) % kDepth; };
  const std::size_t fresh = index(0);
  for (std::size_t k = 0; k < count_; ++k)
    products_[fresh][index(k)] = products_[index(k)][fresh] = noted.with_step[index(k)];
  Small products(count, count);
  Few right(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const std::size_t row = index(static_cast<std::size_t>(r));
    right[r] = noted.with_last[row];
    for (Eigen::Index c = 0; c < count; ++c) products(r, c) = products_[row][index(static_cast<std::size_t>(c))];
  }
  products.diagonal().array() += kRidge * products.trace();
  const Few parts = products.ldlt().solve(right);
  if (!parts.allFinite()) return false;
  std::array<const double*, kDepth> steps{};
  for (std::size_t k = 0; k < count_; ++k) steps[k] = after_steps_[index(k)].data();
  subtract_steps(std::span(steps).first(count_), {parts.data(), count_}, after.first(size_));
  return true;
}

}  // namespace poise::solver
