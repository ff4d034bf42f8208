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

/// Memory for at least `n` elements, of which none is kept where that is new memory: it is not filled from the old one.
template <class T>
void reserve_anew(UnsetVector<T>& list, std::size_t n) {
  if (n <= list.capacity()) return;
  list = UnsetVector<T>();
  list.reserve(n);
}

/// The same; new memory is at least twice as much.
template <class T>
void make_room_anew(UnsetVector<T>& list, std::size_t n) {
  const std::size_t twice = 2 * list.capacity();
  if (n > list.capacity()) reserve_anew(list, n > twice ? n : twice);
}

/// At least `n` elements, of which none is kept where they need new memory.
template <class T>
void grow_anew(UnsetVector<T>& list, std::size_t n) {
  make_room_anew(list, n);
  if (n > list.size()) list.resize(n);
}

}  // namespace poise::parallel
