// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

#include "parallel/ranges.h"
#include "parallel/unset_vector.h"

namespace poise::solver {

/// Memory that arrays of several types use in turns: in a frame points that refinement has found, then rows and
/// overlapping points of impacts, then contact points in lanes. Invariant: it only grows.
class LaneMemory {
 public:
  /// Memory for `n` elements. Those that there are are lost where that is new memory.
  template <class T>
  void reserve(std::size_t n) {
    parallel::reserve_anew(parts_, parts_of<T>(n));
  }
  template <class First, class Second>
  void reserve(std::size_t first, std::size_t second) {
    parallel::reserve_anew(parts_, parts_of<First>(first) + parts_of<Second>(second));
  }
  /// `n` elements, which hold anything.
  template <class T>
  std::span<T> use_anew(std::size_t n) {
    const std::size_t parts = parts_of<T>(n);
    parallel::make_room_anew(parts_, parts);
    return elements<T>(0, n, parts);
  }
  /// The same of two arrays at once, one behind the other.
  template <class First, class Second>
  std::pair<std::span<First>, std::span<Second>> use_anew(std::size_t first, std::size_t second) {
    const std::size_t begin = parts_of<First>(first);
    const std::size_t parts = begin + parts_of<Second>(second);
    parallel::make_room_anew(parts_, parts);
    return {elements<First>(0, first, parts), elements<Second>(begin, second, parts)};
  }
  /// `n` elements. Those that are there hold what they held if their type is that of the last call.
  template <class T>
  std::span<T> use(std::size_t n, parallel::Executor& executor) {
    const std::size_t parts = parts_of<T>(n);
    if (parts > parts_.capacity()) parallel::reserve(executor, parts_, std::max(parts, 2 * parts_.capacity()));
    return elements<T>(0, n, parts);
  }

 private:
  struct alignas(128) Part {
    std::byte bytes[128];
  };
  template <class T>
  static std::size_t parts_of(std::size_t n) {
    return (n * sizeof(T) + sizeof(Part) - 1) / sizeof(Part);
  }
  template <class T>
  std::span<T> elements(std::size_t begin, std::size_t n, std::size_t parts) {
    static_assert(alignof(T) <= alignof(Part) && std::is_trivially_destructible_v<T>);
    if (parts > parts_.size()) parts_.resize(parts);
    return {reinterpret_cast<T*>(parts_.data() + begin), n};
  }

  parallel::UnsetVector<Part> parts_;
};

}  // namespace poise::solver
