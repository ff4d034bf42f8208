// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace poise::parallel {

/// Asks the system to use large pages for this memory, so that random access to large arrays causes fewer misses of
/// page tables. A hint: on systems without large pages (Linux has transparent ones on request) the pages stay small.
/// Any thread.
void prefer_large_pages(void* memory, std::size_t bytes) noexcept;

/// Allocator for large arrays of a step. Arrays of kFromBytes and more begin at a large page. The first touch of a
/// large page takes some milliseconds, so arrays of small scenes, which are stepped in that time, use small pages.
template <class T>
struct LargePages {
  using value_type = T;
  using is_always_equal = std::true_type;
  static constexpr std::size_t kPageBytes = std::size_t{2} << 20U;
  static constexpr std::size_t kFromBytes = 16 * kPageBytes;

  LargePages() = default;
  template <class U>
  LargePages(const LargePages<U>&) noexcept {}

  T* allocate(std::size_t n) {
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
    void* const memory = ::operator new(n * sizeof(T), alignment(n));
    if (n * sizeof(T) >= kFromBytes) prefer_large_pages(memory, n * sizeof(T));
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) noexcept { ::operator delete(memory, alignment(n)); }
  template <class U>
  bool operator==(const LargePages<U>&) const noexcept {
    return true;
  }

 private:
  static std::align_val_t alignment(std::size_t n) {
    return std::align_val_t{n * sizeof(T) >= kFromBytes ? kPageBytes : alignof(T)};
  }
};

template <class T>
using LargeVector = std::vector<T, LargePages<T>>;

/// The same, but resize() does not set what it adds: for arrays whose elements are all written before they are read, so
/// that each is written once, by the worker that makes it, and new pages are touched in parallel.
template <class T>
struct UnsetPages : LargePages<T> {
  static_assert(std::is_trivially_destructible_v<T>);
  using value_type = T;
  UnsetPages() = default;
  template <class U>
  UnsetPages(const UnsetPages<U>& /*other*/) noexcept {}
  template <class U>
  struct rebind {  // NOLINT(readability-identifier-naming): the name that std::allocator_traits asks for
    using other = UnsetPages<U>;
  };
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    if constexpr (sizeof...(Arguments) > 0) std::construct_at(at, std::forward<Arguments>(arguments)...);
  }
};

template <class T>
using UnsetVector = std::vector<T, UnsetPages<T>>;

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
