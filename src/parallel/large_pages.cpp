// SPDX-License-Identifier: MIT
#include "parallel/large_pages.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace poise::parallel {

void prefer_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  static_cast<void>(madvise(memory, bytes, MADV_HUGEPAGE));
#endif
}

}  // namespace poise::parallel
