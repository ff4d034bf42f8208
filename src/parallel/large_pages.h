// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <new>
#include <type_traits>
#include <vector>

namespace poise::parallel {

/// Asks the system to hold this memory in large pages, so that going through much of it in no order does not wait for
/// page tables. A wish: where there are none (Linux has them, transparent, on request) the pages stay small. Any
/// thread.
void prefer_large_pages(void* memory, std::size_t bytes) noexcept;

/// Allocator for arrays that a step goes through. Those of kFromBytes and more begin at a large page: the first touch
/// of one takes some milliseconds, so that arrays of scenes which are stepped in that time have small ones.
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

}  // namespace poise::parallel
