// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace poise::parallel {

/// Allocator of a vector whose resize() does not set what it adds.
template <class T>
struct Unset : std::allocator<T> {
  static_assert(std::is_trivially_destructible_v<T>);
  Unset() = default;
  template <class U>
  Unset(const Unset<U>& /*other*/) noexcept {}
  template <class U>
  struct rebind {  // NOLINT(readability-identifier-naming): the name that std::allocator_traits asks for
    using other = Unset<U>;
  };
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    if constexpr (sizeof...(Arguments) > 0) std::construct_at(at, std::forward<Arguments>(arguments)...);
  }
};

/// For arrays of a step whose elements are all written before they are read: each is written once, by the worker that
/// makes it, and new pages are touched in parallel. Small pages, whatever the size: the first touch of a large one
/// takes 4 ms, which no slice of a frame can interrupt, and no scene gained by them (docs/scheduling.md, "New memory").
template <class T>
using UnsetVector = std::vector<T, Unset<T>>;

/// At least `n` elements, of which none is kept: new memory is not filled from the old one, and is twice as much.
template <class T>
void grow_anew(UnsetVector<T>& list, std::size_t n) {
  if (n <= list.size()) return;
  if (n > list.capacity()) {
    const std::size_t twice = 2 * list.capacity();
    list.clear();
    list.reserve(n > twice ? n : twice);
  }
  list.resize(n);
}

}  // namespace poise::parallel
