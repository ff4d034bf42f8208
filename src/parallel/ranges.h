// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "parallel/executor.h"
#include "parallel/unset_vector.h"

namespace poise::parallel {

/// [0, n) in consecutive ranges of nearly equal length, each of at least `least` items, at most kMost of them: so what
/// is done once a range between two loops does not grow with n. The ranges depend on n and `least` alone.
struct Ranges {
  static constexpr std::size_t kMost = 64;
  Ranges(std::size_t items, std::size_t least)
      : n(items), count(std::clamp<std::size_t>(items / std::max<std::size_t>(least, 1), 1, kMost)) {}
  [[nodiscard]] std::size_t begin(std::size_t range) const { return n * range / count; }
  [[nodiscard]] std::size_t end(std::size_t range) const { return begin(range + 1); }

  std::size_t n, count;
};

/// Calls body(range, begin, end) for each range. Calls may overlap.
template <class Body>
void for_ranges(Executor& executor, const Ranges& ranges, Body&& body) {
  parallel_for(executor, ranges.count, 1,
               [&](std::size_t k, std::size_t, int) { body(k, ranges.begin(k), ranges.end(k)); });
}

/// list.resize(n, value), but what that adds is set in parallel.
template <class T>
void resize(Executor& executor, UnsetVector<T>& list, std::size_t n, const T& value = {}) {
  const std::size_t before = list.size();
  list.resize(n);
  if (n <= before) return;
  for_ranges(executor, {n - before, 64}, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::fill(list.begin() + static_cast<std::ptrdiff_t>(before + begin),
              list.begin() + static_cast<std::ptrdiff_t>(before + end), value);
  });
}

/// Calls write(i, position) for the items of [0, n) that keep(i) is true of, with their position among them, in
/// parallel; before that room(count) with their number, on the calling thread. keep is called twice an item and must
/// return the same. `counts` is scratch.
template <class Keep, class Room, class Write>
void select(Executor& executor, std::size_t n, std::size_t least, std::vector<std::size_t>& counts, Keep&& keep,
            Room&& room, Write&& write) {
  const Ranges ranges(n, least);
  counts.reserve(Ranges::kMost);
  counts.assign(ranges.count, 0);
  for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i) count += keep(i) ? 1U : 0U;
    counts[range] = count;
  });
  std::size_t sum = 0;
  for (std::size_t& count : counts) count = std::exchange(sum, sum + count);
  room(sum);
  if (sum == 0) return;
  for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    std::size_t position = counts[range];
    for (std::size_t i = begin; i < end; ++i) {
      if (keep(i)) write(i, position++);
    }
  });
}

/// Puts the items of [0, n) into groups, each in order, in parallel: calls write(i, group, position in the group) for
/// each, and before that room(sizes) with the number of each group, on the calling thread. group_of is called twice an
/// item and must return the same, below `groups`. `counts` is scratch.
template <class GroupOf, class Room, class Write>
void group(Executor& executor, std::size_t n, std::size_t least, std::size_t groups, std::vector<std::size_t>& counts,
           GroupOf&& group_of, Room&& room, Write&& write) {
  const Ranges ranges(n, least);
  // Of each range, and before these of all.
  counts.assign((ranges.count + 1) * groups, 0);
  for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ++counts[(range + 1) * groups + group_of(i)];
  });
  for (std::size_t range = 1; range <= ranges.count; ++range) {
    for (std::size_t g = 0; g < groups; ++g) {
      std::size_t& count = counts[range * groups + g];
      count = std::exchange(counts[g], counts[g] + count);
    }
  }
  room(std::span<const std::size_t>(counts).first(groups));
  for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t of_item = group_of(i);
      write(i, of_item, counts[(range + 1) * groups + of_item]++);
    }
  });
}

/// Merges two sorted lists of which no two items are equal: calls write(item, position) for each, in parallel.
template <class List, class Before, class Write>
void merge(Executor& executor, std::size_t least, const List& a, const List& b, Before&& before, Write&& write) {
  const auto merge_in = [&](const List& own, const List& other) {
    for_ranges(executor, {own.size(), least}, [&](std::size_t, std::size_t begin, std::size_t end) {
      if (begin == end) return;
      auto at = std::lower_bound(other.begin(), other.end(), own[begin], before);
      for (std::size_t i = begin; i < end; ++i) {
        while (at != other.end() && before(*at, own[i])) ++at;
        write(own[i], i + static_cast<std::size_t>(at - other.begin()));
      }
    });
  };
  merge_in(a, b);
  merge_in(b, a);
}

}  // namespace poise::parallel
