// SPDX-License-Identifier: MIT
#include "solver/coloring.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace poise::solver {
namespace {

// A bit by colour; none of what has no colour.
std::uint64_t bit_of(std::uint32_t color) { return color < kColors ? std::uint64_t{1} << color : 0; }

// Ranges of edges whose counts are summed up one after another between two loops: no more than the threads need.
constexpr std::size_t kEdgeRanges = 16, kRangesOfThread = 2;
// Phases with fewer edges are coloured by the calling thread: that takes no longer than to begin and end a loop.
constexpr std::size_t kEdgesAlone = 256;

parallel::Ranges ranges_of(std::size_t edges, const parallel::Executor& executor) {
  if (executor.concurrency() == 1 || edges < Coloring::kTiledEdges) return {edges, std::max<std::size_t>(edges, 1)};
  const std::size_t ranges = std::min(kEdgeRanges, kRangesOfThread * static_cast<std::size_t>(executor.concurrency()));
  return {edges, std::max(Coloring::kTiledEdges / 4, edges / ranges)};
}

// Bins that follow each other.
struct BinRange {
  std::size_t begin = 0, end = 0;
};

// From how many items of each bin there are in each range of items to where they begin in a list of all, bin by bin and
// within a bin range by range. Goes through the counts in the order of memory, and only through `used`, ascending: all
// other bins are empty, and nothing is written of them.
template <std::size_t kCount>
void begin_bins(std::span<const BinRange> used, std::vector<std::array<std::uint32_t, kCount>>& counts,
                std::array<std::uint32_t, kCount + 1>& begin) {
  const auto for_bins = [used](auto&& work) {
    for (const BinRange& range : used) {
      for (std::size_t bin = range.begin; bin < range.end; ++bin) work(bin);
    }
  };
  for_bins([&](std::size_t bin) { begin[bin] = 0; });
  for (const auto& of_range : counts) for_bins([&](std::size_t bin) { begin[bin] += of_range[bin]; });
  std::array<std::uint32_t, kCount> next;
  std::uint32_t sum = 0;
  for_bins([&](std::size_t bin) {
    begin[bin] = std::exchange(sum, sum + begin[bin]);
    next[bin] = begin[bin];
  });
  begin[kCount] = sum;
  for (auto& of_range : counts) {
    for_bins([&](std::size_t bin) {
      const std::uint32_t count = of_range[bin];
      of_range[bin] = next[bin];
      next[bin] += count;
    });
  }
}

}  // namespace

// The first colour of its kind that is free at both bodies of an edge, where it is then used; kColors if there is none.
std::uint32_t Coloring::pick(const Edge& edge) {
  const std::uint64_t used =
      (edge.dynamic_a ? used_[edge.a] : 0) | (edge.dynamic_b ? used_[edge.b] : 0) | colors_of_others(edge);
  const auto color = static_cast<std::uint32_t>(std::countr_one(used));
  if (color == kColors) return color;
  const std::uint64_t mark = std::uint64_t{1} << color;
  if (edge.dynamic_a) used_[edge.a] |= mark;
  if (edge.dynamic_b) used_[edge.b] |= mark;
  return color;
}

// Of the bins of a colour: parts of the slots, and in each the ranks, the highest first. Edges without a colour share
// one bin, and so keep their order.
template <std::size_t kPartCount>
std::uint16_t Coloring::bin_of(const Edge& edge, std::uint32_t color) const {
  if (color == kColors) return static_cast<std::uint16_t>(color * kPartCount * kRanks);
  std::uint32_t part = 0;
  if constexpr (kPartCount > 1)
    part = std::min(edge.dynamic_a ? edge.a : edge.b, edge.dynamic_b ? edge.b : edge.a) >> part_shift_;
  return static_cast<std::uint16_t>((color * kPartCount + part) * kRanks + kRanks - 1 - edge.rank);
}

void Coloring::reserve_tiles() {
  tile_counts_.reserve(kEdgeRanges);
  bin_counts_.reserve(kEdgeRanges);
  waiting_.reserve(kTiles);
  phase_tiles_.reserve(kTiles);
  phase_begin_.reserve(kTiles + 1);
  colors_of_tile_.reserve(kTiles);
}

void Coloring::sort_into_tiles(std::span<const Edge> edges, const parallel::Ranges& ranges,
                               parallel::Executor& executor) {
  tile_counts_.resize(ranges.count);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    TileCounts& counts = tile_counts_[range];
    counts.fill(0);
    for (std::size_t i = begin; i < end; ++i) {
      const Edge& edge = edges[i];
      const std::uint32_t a = (edge.dynamic_a ? edge.a : edge.b) >> body_shift_;
      const std::uint32_t b = (edge.dynamic_b ? edge.b : edge.a) >> body_shift_;
      const std::size_t tile = std::min(a, b) * kBodyRanges + std::max(a, b);
      tile_of_[i] = static_cast<std::uint16_t>(tile);
      ++counts[tile];
    }
  });
  constexpr std::array kAll{BinRange{0, kTiles}};
  begin_bins<kTiles>(kAll, tile_counts_, tile_begin_);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    TileCounts& next = tile_counts_[range];
    for (std::size_t i = begin; i < end; ++i) by_tile_[next[tile_of_[i]]++] = static_cast<std::uint32_t>(i);
  });
}

// Of the tiles that are left, the largest first, each phase takes those whose two ranges no other has taken: so tiles
// of like size are coloured at the same time.
void Coloring::plan_phases() {
  const auto size = [&](std::uint16_t tile) { return tile_begin_[tile + 1U] - tile_begin_[tile]; };
  waiting_.clear();
  for (std::uint16_t tile = 0; tile < kTiles; ++tile) {
    if (size(tile) > 0) waiting_.push_back(tile);
  }
  std::sort(waiting_.begin(), waiting_.end(),
            [&](std::uint16_t x, std::uint16_t y) { return std::pair(size(y), x) < std::pair(size(x), y); });
  phase_tiles_.clear();
  phase_begin_.assign(1, 0);
  while (!waiting_.empty()) {
    std::uint32_t taken = 0;
    std::erase_if(waiting_, [&](std::uint16_t tile) {
      const std::uint32_t ranges = 1U << (tile / kBodyRanges) | 1U << (tile % kBodyRanges);
      if ((taken & ranges) != 0) return false;
      taken |= ranges;
      phase_tiles_.push_back(tile);
      return true;
    });
    phase_begin_.push_back(phase_tiles_.size());
  }
}

std::uint64_t Coloring::color_tile(std::span<const Edge> edges, std::uint16_t tile) {
  std::uint64_t colors = 0;
  for (std::uint32_t at = tile_begin_[tile]; at < tile_begin_[tile + 1U]; ++at) {
    const std::uint32_t edge = by_tile_[at];
    const std::uint32_t color = pick(edges[edge]);
    bin_of_[edge] = bin_of<kParts>(edges[edge], color);
    colors |= bit_of(color);
  }
  return colors;
}

std::uint64_t Coloring::color_tiles(std::span<const Edge> edges, parallel::Executor& executor) {
  colors_of_tile_.assign(kTiles, 0);
  for (std::size_t phase = 0; phase + 1 < phase_begin_.size(); ++phase) {
    const std::span<const std::uint16_t> tiles =
        std::span(phase_tiles_).subspan(phase_begin_[phase], phase_begin_[phase + 1] - phase_begin_[phase]);
    std::size_t count = 0;
    for (const std::uint16_t tile : tiles) count += tile_begin_[tile + 1U] - tile_begin_[tile];
    const std::size_t grain = count < kEdgesAlone ? tiles.size() : 1;
    parallel::parallel_for(executor, tiles.size(), grain, [&](std::size_t begin, std::size_t end, int) {
      for (const std::uint16_t tile : tiles.subspan(begin, end - begin))
        colors_of_tile_[tile] = color_tile(edges, tile);
    });
  }
  std::uint64_t all = 0;
  for (const std::uint64_t colors : colors_of_tile_) all |= colors;
  return all;
}

void Coloring::sort_by_color(std::uint64_t colors, std::size_t bins_of_color, const parallel::Ranges& ranges,
                             parallel::Executor& executor) {
  // A few edges have a few of the colours. Those without one come last.
  std::array<BinRange, kColors + 1> bins;
  std::size_t used = 0;
  for (; colors != 0; colors &= colors - 1) {
    const auto color = static_cast<std::size_t>(std::countr_zero(colors));
    bins[used++] = {color * bins_of_color, (color + 1) * bins_of_color};
  }
  bins[used++] = {kColors * bins_of_color, kColors * bins_of_color + kRanks};
  const std::span<const BinRange> all(bins.data(), used);
  bin_counts_.resize(ranges.count);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    BinCounts& counts = bin_counts_[range];
    for (const BinRange& of_color : all) std::fill(&counts[of_color.begin], &counts[of_color.end - 1] + 1, 0U);
    for (std::size_t i = begin; i < end; ++i) ++counts[bin_of_[i]];
  });
  std::array<std::uint32_t, kBins + 1> bin_begin;
  begin_bins<kBins>(all, bin_counts_, bin_begin);
  begin_.assign(1, 0);
  for (std::size_t k = 0; k + 1 < used; ++k) {
    const std::size_t end = bin_begin[bins[k + 1].begin];
    if (end > begin_.back()) begin_.push_back(end);
  }
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    BinCounts& next = bin_counts_[range];
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t place = next[bin_of_[i]]++;
      places_[i] = place;
      order_[place] = static_cast<std::uint32_t>(i);
    }
  });
}

void Coloring::color_own(std::span<const Edge> edges, std::size_t bodies, parallel::Executor& executor) {
  used_.assign(bodies, 0);
  bin_of_.resize(edges.size());
  order_.resize(edges.size());
  places_.resize(edges.size());
  const parallel::Ranges ranges = ranges_of(edges.size(), executor);
  if (edges.size() < kTiledEdges) {
    std::uint64_t colors = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const std::uint32_t color = pick(edges[i]);
      bin_of_[i] = bin_of<1>(edges[i], color);
      colors |= bit_of(color);
    }
    sort_by_color(colors, kRanks, ranges, executor);
    return;
  }
  const auto shift_to = [bits = static_cast<int>(std::bit_width(bodies - 1))](int left) {
    return std::max(bits - left, 0);
  };
  body_shift_ = shift_to(std::countr_zero(kBodyRanges));
  part_shift_ = shift_to(std::countr_zero(kParts));
  tile_of_.resize(edges.size());
  by_tile_.resize(edges.size());
  sort_into_tiles(edges, ranges, executor);
  plan_phases();
  sort_by_color(color_tiles(edges, executor), kParts * kRanks, ranges, executor);
}

void Coloring::color(std::span<const Edge> edges, std::size_t bodies, parallel::Executor& executor) {
  color_own(edges, bodies, executor);
  own_colors_ = colors();
  const std::size_t before = begin_.back();
  const std::span<std::uint32_t> left = std::span(order_).subspan(before);
  shared_.color(edges, bodies, left, before, begin_, executor);
  for (std::size_t k = 0; k < left.size(); ++k) places_[left[k]] = static_cast<std::uint32_t>(before + k);
}

void Coloring::color(std::span<const Edge> edges, std::size_t bodies) {
  color(edges, bodies, *parallel::make_executor(ExecutorKind::Serial, 1));
}

}  // namespace poise::solver
