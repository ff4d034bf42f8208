// SPDX-License-Identifier: MIT
#include "solver/shared_bodies.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "parallel/ranges.h"

namespace poise::solver {
namespace {

constexpr std::uint32_t kUnknown = 0xffffffffU;
constexpr std::size_t kBinsOfEdges = std::size_t{kColors} * kRanks;

}  // namespace

void SharedBodies::clear() {
  shared_.clear();
  ends_.clear();
  copies_ = 0;
}

SharedBodies::Body& SharedBodies::body_of(std::uint32_t name) {
  if (index_[name] == kUnknown) {
    index_[name] = static_cast<std::uint32_t>(bodies_.size());
    bodies_.push_back({name, 0, 0, 0});
  }
  return bodies_[index_[name]];
}

// The first colour that is free at both ends; where there is none, the end that has fewer left goes on as a new copy.
SharedBodies::Colored SharedBodies::pick(const Edge& edge) {
  Body none;
  if (edge.dynamic_a) body_of(edge.a);
  if (edge.dynamic_b) body_of(edge.b);
  Body& a = edge.dynamic_a ? bodies_[index_[edge.a]] : none;
  Body& b = edge.dynamic_b ? bodies_[index_[edge.b]] : none;
  const std::uint64_t others = colors_of_others(edge);
  std::uint64_t used = a.used | b.used | others;
  for (; ~used == 0; used = a.used | b.used | others) {
    Body& fuller = std::popcount(a.used & ~others) >= std::popcount(b.used & ~others) ? a : b;
    ++fuller.copy;
    fuller.used = 0;
  }
  const auto color = static_cast<std::uint32_t>(std::countr_one(used));
  a.used |= std::uint64_t{1} << color;
  b.used |= std::uint64_t{1} << color;
  return {static_cast<std::uint16_t>(color * kRanks + kRanks - 1 - edge.rank), a.copy, b.copy};
}

void SharedBodies::sort(std::span<std::uint32_t> order, std::size_t before, std::vector<std::size_t>& ends_of_colors) {
  std::array<std::uint32_t, kBinsOfEdges + 1> begin{};
  for (const Colored& edge : colored_) ++begin[edge.bin + 1U];
  for (std::size_t bin = 0; bin < kBinsOfEdges; ++bin) begin[bin + 1] += begin[bin];
  for (std::size_t color = 0; color < kColors; ++color) {
    const std::size_t end = before + begin[(color + 1) * kRanks];
    if (end > ends_of_colors.back()) ends_of_colors.push_back(end);
  }
  sorted_.resize(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) sorted_[begin[colored_[k].bin]++] = order[k];
  std::ranges::copy(sorted_, order.begin());
}

// `order` as it came in.
void SharedBodies::name_ends(std::span<const Edge> edges, std::size_t bodies, std::span<const std::uint32_t> order,
                             parallel::Executor& executor) {
  constexpr std::size_t kGrain = 2048;
  for (Body& body : bodies_) {
    if (body.copy == 0) continue;
    body.first = static_cast<std::uint32_t>(bodies + copies_);
    shared_.push_back({body.name, body.first, body.copy + 1});
    copies_ += body.copy + 1;
  }
  if (shared_.empty()) return;
  const auto end_of = [&](std::uint32_t name, std::uint32_t copy) {
    if (index_[name] == kUnknown) return name;
    const Body& body = bodies_[index_[name]];
    return body.copy == 0 ? name : body.first + copy;
  };
  ends_.resize(edges.size());
  // Edges with a colour of the first set push the first copy.
  parallel::parallel_for(executor, edges.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) ends_[i] = {end_of(edges[i].a, 0), end_of(edges[i].b, 0)};
  });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Edge& edge = edges[order[k]];
    ends_[order[k]] = {end_of(edge.a, colored_[k].copy_a), end_of(edge.b, colored_[k].copy_b)};
  }
}

void SharedBodies::color(std::span<const Edge> edges, std::size_t bodies, std::span<std::uint32_t> order,
                         std::size_t before, std::vector<std::size_t>& ends_of_colors, parallel::Executor& executor) {
  clear();
  if (order.empty()) return;
  index_.assign(bodies, kUnknown);
  bodies_.clear();
  colored_.clear();
  for (const std::uint32_t edge : order) colored_.push_back(pick(edges[edge]));
  name_ends(edges, bodies, order, executor);
  sort(order, before, ends_of_colors);
}

}  // namespace poise::solver
