// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/executor.h"
#include "parallel/ranges.h"
#include "parallel/unset_vector.h"
#include "solver/edge.h"
#include "solver/shared_bodies.h"

namespace poise::solver {

/// Order of rows such that no two rows of one colour push the same dynamic body, or the same copy of one; within a
/// colour by rank, the highest first. Of many rows, those of each colour are ordered by eighths of the body slots
/// first, so that the thread that takes a part of a colour finds in its cache the bodies that it has written in the
/// last one. Deterministic for the rows' order, whatever the number of threads. Invariant: begin has one more entry
/// than there are colours.
///
/// Each row gets the first colour that is free at both bodies, rows with a body that is not dynamic one of the last
/// colours. Many rows are coloured in parallel: bodies are divided
/// into ranges of slots and rows into tiles, those between the same two ranges. Tiles without a range in common share
/// no body. They make up a phase, whose tiles are coloured at the same time; phases follow each other. Rows for which
/// no colour is free get one of a second set (SharedBodies), and come last.
class Coloring {
 public:
  /// Fewer are one tile. Chosen: 40 us of work, about the cost of the loops that more tiles need.
  static constexpr std::size_t kTiledEdges = 4096;
  void color(std::span<const Edge> edges, std::size_t bodies, parallel::Executor& executor);
  /// The same on the calling thread.
  void color(std::span<const Edge> edges, std::size_t bodies);
  /// Forgets the colours, where it needs new memory.
  void reserve(std::size_t edges) {
    parallel::reserve_anew(bin_of_, edges);
    parallel::reserve_anew(tile_of_, edges);
    parallel::reserve_anew(by_tile_, edges);
    parallel::reserve_anew(order_, edges);
    parallel::reserve_anew(places_, edges);
    begin_.reserve(2 * kColors + 1);
    if (edges >= kTiledEdges) reserve_tiles();
  }
  /// order()[k] is the edge at position k; positions of colour c are [begin(c), begin(c + 1)). Only colours that have
  /// edges count: between those of pairs of dynamic bodies and those of the ground most are free.
  [[nodiscard]] std::span<const std::uint32_t> order() const { return order_; }
  /// The position of each edge: order()[places()[i]] is i.
  [[nodiscard]] std::span<const std::uint32_t> places() const { return places_; }
  [[nodiscard]] std::uint32_t colors() const { return static_cast<std::uint32_t>(begin_.size() - 1); }
  [[nodiscard]] std::size_t begin(std::uint32_t color) const { return begin_[color]; }
  /// Edges from this position on have a colour of the second set: two of a colour may push the same body, as copies.
  [[nodiscard]] std::size_t shared_begin() const { return begin_[own_colors_]; }
  /// How many colours come before it.
  [[nodiscard]] std::uint32_t own_colors() const { return own_colors_; }
  [[nodiscard]] std::span<const SharedBody> shared() const { return shared_.all(); }
  /// Of all shared bodies.
  [[nodiscard]] std::size_t copies() const { return shared_.copies(); }
  /// The bodies of each edge, or copies of them; none where no body is shared.
  [[nodiscard]] std::span<const RowEnds> ends() const { return shared_.ends(); }

 private:
  static constexpr std::size_t kBodyRanges = 32;
  static constexpr std::size_t kTiles = kBodyRanges * kBodyRanges;
  static constexpr std::size_t kParts = 8;                               // of the slots; chosen (docs/performance.md)
  static constexpr std::size_t kBins = (kColors + 1) * kParts * kRanks;  // a colour, part and rank each
  using TileCounts = std::array<std::uint32_t, kTiles>;
  using BinCounts = std::array<std::uint32_t, kBins>;

  void color_own(std::span<const Edge> edges, std::size_t bodies, parallel::Executor& executor);
  std::uint32_t pick(const Edge& edge);
  template <std::size_t kPartCount>
  [[nodiscard]] std::uint16_t bin_of(const Edge& edge, std::uint32_t color) const;
  void reserve_tiles();
  void sort_into_tiles(std::span<const Edge> edges, const parallel::Ranges& ranges, parallel::Executor& executor);
  void plan_phases();
  // Both return which colours they have, a bit each.
  std::uint64_t color_tile(std::span<const Edge> edges, std::uint16_t tile);
  std::uint64_t color_tiles(std::span<const Edge> edges, parallel::Executor& executor);
  /// `colors`: a bit for each that edges have.
  void sort_by_color(std::uint64_t colors, std::size_t bins_of_color, const parallel::Ranges& ranges,
                     parallel::Executor& executor);

  std::vector<std::uint64_t> used_;  // one a body: bit by colour
  parallel::UnsetVector<std::uint16_t> bin_of_, tile_of_;
  parallel::UnsetVector<std::uint32_t> by_tile_;      // edges, tile by tile, in canonical order within a tile
  std::vector<TileCounts> tile_counts_;               // one a range of edges
  std::vector<BinCounts> bin_counts_;                 // likewise
  std::array<std::uint32_t, kTiles + 1> tile_begin_;  // in by_tile_
  std::vector<std::uint16_t> waiting_, phase_tiles_;  // tiles
  std::vector<std::size_t> phase_begin_;              // in phase_tiles_
  std::vector<std::uint64_t> colors_of_tile_;         // a bit by colour
  int body_shift_ = 0;                                // a body's range is its slot without so many bits
  int part_shift_ = 0;                                // as body_shift_, of a part
  parallel::UnsetVector<std::uint32_t> order_, places_;
  std::vector<std::size_t> begin_ = {0};
  std::uint32_t own_colors_ = 0;
  SharedBodies shared_;
};

}  // namespace poise::solver
