// SPDX-License-Identifier: MIT
#include "solver/impact_row.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace poise::solver {

bool prepare_row(Wrench& wrench, double inverse_mass_a, const Mat3& inverse_inertia_a, double inverse_mass_b,
                 const Mat3& inverse_inertia_b) {
  wrench.turn_a = inverse_inertia_a * wrench.moment_a_m;
  wrench.turn_b = inverse_inertia_b * wrench.moment_b_m;
  const double k = wrench.direction.squaredNorm() * (inverse_mass_a + inverse_mass_b) +
                   wrench.moment_a_m.dot(wrench.turn_a) + wrench.moment_b_m.dot(wrench.turn_b);
  // Opposed normals can cancel; below 1e-7 of what one contact would have the row counts as degenerate.
  const bool sound = std::isfinite(k) && k > 1e-7 * (inverse_mass_a + inverse_mass_b);
  wrench.effective_mass = sound ? 1.0 / k : 0.0;
  return sound;
}

void Coloring::color(std::span<const Edge> edges, std::size_t bodies) {
  used_.assign(bodies, 0);
  bin_of_.resize(edges.size());
  // A bin a colour and rank, the highest rank first. Edges without a colour keep their order.
  std::size_t count[(kColors + 1) * kRanks] = {};
  colors_ = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Edge& edge = edges[i];
    const std::uint64_t used = (edge.dynamic_a ? used_[edge.a] : 0) | (edge.dynamic_b ? used_[edge.b] : 0);
    const auto color = static_cast<std::uint32_t>(std::countr_one(used));
    const std::uint32_t bin = color * kRanks + (color == kColors ? 0 : kRanks - 1 - edge.rank);
    bin_of_[i] = static_cast<std::uint16_t>(bin);
    ++count[bin];
    if (color == kColors) continue;
    const std::uint64_t mark = std::uint64_t{1} << color;
    if (edge.dynamic_a) used_[edge.a] |= mark;
    if (edge.dynamic_b) used_[edge.b] |= mark;
    colors_ = std::max(colors_, color + 1);
  }
  begin_.resize(kColors + 2);
  std::size_t next[(kColors + 1) * kRanks];
  std::size_t sum = 0;
  for (std::uint32_t bin = 0; bin < (kColors + 1) * kRanks; ++bin) {
    if (bin % kRanks == 0) begin_[bin / kRanks] = sum;
    next[bin] = sum;
    sum += count[bin];
  }
  begin_[kColors + 1] = sum;
  order_.resize(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) order_[next[bin_of_[i]]++] = static_cast<std::uint32_t>(i);
}

}  // namespace poise::solver
