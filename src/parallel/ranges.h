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

/// [0, n) in consecutive ranges of nearly equal length, each of at least `least` items. At most kMost of them, so that
/// what is done once a range between two loops does not grow with n; but for so many items that a range would be longer
/// than kLong, which takes too long for one item of a loop that has to stop in time. The ranges depend on n and `least`
/// alone.
struct Ranges {
  static constexpr std::size_t kMost = 64;
  static constexpr std::size_t kLong = 8192;
  Ranges(std::size_t items, std::size_t least)
      : n(items),
        count(std::clamp<std::size_t>(items / std::max<std::size_t>(least, 1), 1, std::max(kMost, items / kLong))) {}
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

/// Elements of which the memory may be touched for the first time in one item of a loop: 16 small pages, which the
/// system may take 0.2 ms for.
template <class T>
inline constexpr std::size_t kTouchGrain = std::max<std::size_t>((std::size_t{1} << 16U) / sizeof(T), 1);

/// Memory for at least `n` elements; those that there are are copied in parallel.
template <class T>
void reserve(Executor& executor, UnsetVector<T>& list, std::size_t n) {
  if (n <= list.capacity()) return;
  UnsetVector<T> larger;
  larger.reserve(n);
  larger.resize(list.size());
  parallel_for(executor, list.size(), kTouchGrain<T>, [&](std::size_t begin, std::size_t end, int) {
    std::copy(list.begin() + static_cast<std::ptrdiff_t>(begin), list.begin() + static_cast<std::ptrdiff_t>(end),
              larger.begin() + static_cast<std::ptrdiff_t>(begin));
  });
  list.swap(larger);
}

/// list.resize(n, value), but what that adds is set in parallel.
template <class T>
void resize(Executor& executor, UnsetVector<T>& list, std::size_t n, const T& value = {}) {
  const std::size_t before = list.size();
  list.resize(n);
  if (n <= before) return;
  parallel_for(executor, n - before, kTouchGrain<T>, [&](std::size_t begin, std::size_t end, int) {
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

/// Sorts items of which no two are equal, in parallel and in pieces of about kRun items: runs, and then pairs of runs
/// merged, each piece of the result by itself. `scratch` holds as many afterwards, of no meaning.
template <class T, class Before>
void sort(Executor& executor, std::vector<T>& list, std::vector<T>& scratch, Before&& before) {
  constexpr std::size_t kRun = 2048;
  const std::size_t n = list.size();
  parallel_for(executor, n, kRun, [&](std::size_t begin, std::size_t end, int) {
    std::sort(list.begin() + static_cast<std::ptrdiff_t>(begin), list.begin() + static_cast<std::ptrdiff_t>(end),
              before);
  });
  if (n <= kRun) return;
  scratch.resize(n);
  for (std::size_t run = kRun; run < n; run *= 2) {
    parallel_for(executor, n, kRun, [&](std::size_t begin, std::size_t end, int) {
      const std::size_t first = begin - begin % (2 * run);
      const std::span<const T> both = std::span<const T>(list).subspan(first, std::min(2 * run, n - first));
      const std::span<const T> a = both.first(std::min(run, both.size()));
      const std::span<const T> b = both.subspan(a.size());
      // How many of the first k are of a.
      const auto of_a = [&](std::size_t k) {
        std::size_t low = k - std::min(k, b.size());
        std::size_t high = std::min(k, a.size());
        while (low < high) {
          const std::size_t i = (low + high) / 2;
          if (i < k && before(a[i], b[k - i - 1])) {
            low = i + 1;
          } else {
            high = i;
          }
        }
        return low;
      };
      const std::size_t from_a = of_a(begin - first);
      const std::size_t to_a = of_a(end - first);
      const std::span<const T> part_a = a.subspan(from_a, to_a - from_a);
      const std::span<const T> part_b = b.subspan(begin - first - from_a, end - begin - part_a.size());
      std::merge(part_a.begin(), part_a.end(), part_b.begin(), part_b.end(),
                 scratch.begin() + static_cast<std::ptrdiff_t>(begin), before);
    });
    list.swap(scratch);
  }
}

}  // namespace poise::parallel
