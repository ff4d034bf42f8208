// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/executor.h"
#include "parallel/unset_vector.h"
#include "solver/edge.h"

namespace poise::solver {

/// A body that several rows of a colour push, each another copy of it: [first, first + copies), numbered behind the
/// bodies.
struct SharedBody {
  std::uint32_t body = 0, first = 0, copies = 0;
};

/// The bodies of a row, of which each may be a copy.
struct RowEnds {
  std::uint32_t a = 0, b = 0;
};

/// Colours of the edges that found none of the first 64: a second set of as many. A body that runs out of these too is
/// split into copies that share its mass (Tonge, Benevolenski and Voroshilov 2012), each with as many edges as there
/// are colours: the edges of a body with thousands of them need no more colours than others do. Calling thread but for
/// the ends, linear in these edges and, to forget the last time, in the bodies. Invariant: buffers only grow.
class SharedBodies {
 public:
  /// `order`: in, edges in canonical order; out, by colour and within a colour by rank, the highest first. Appends
  /// where each colour ends, counted from `before`, to `ends_of_colors`.
  void color(std::span<const Edge> edges, std::size_t bodies, std::span<std::uint32_t> order, std::size_t before,
             std::vector<std::size_t>& ends_of_colors, parallel::Executor& executor);

  [[nodiscard]] std::span<const SharedBody> all() const { return shared_; }
  [[nodiscard]] std::size_t copies() const { return copies_; }
  /// One an edge; none where no body is shared.
  [[nodiscard]] std::span<const RowEnds> ends() const { return ends_; }

 private:
  void clear();
  // What is known of a body of these edges.
  struct Body {
    std::uint32_t name = 0;
    std::uint32_t copy = 0;  // the last one
    std::uint64_t used = 0;  // its colours
    std::uint32_t first = 0;
  };
  struct Colored {
    std::uint16_t bin = 0;
    std::uint32_t copy_a = 0, copy_b = 0;
  };
  Body& body_of(std::uint32_t name);
  Colored pick(const Edge& edge);
  void sort(std::span<std::uint32_t> order, std::size_t before, std::vector<std::size_t>& ends_of_colors);
  void name_ends(std::span<const Edge> edges, std::size_t bodies, std::span<const std::uint32_t> order,
                 parallel::Executor& executor);

  std::vector<std::uint32_t> index_;  // one a body: in bodies_, or none
  std::vector<Body> bodies_;
  std::vector<Colored> colored_;  // as `order` when it comes in
  std::vector<std::uint32_t> sorted_;
  std::vector<SharedBody> shared_;
  std::size_t copies_ = 0;
  parallel::UnsetVector<RowEnds> ends_;
};

}  // namespace poise::solver
