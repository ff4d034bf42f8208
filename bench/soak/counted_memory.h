// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace poise::soak {

/// Calls of operator new in this process so far, by all threads. A program that links this file has its own.
std::uint64_t allocations();
/// Bytes that this process has from malloc now, of all threads (glibc).
std::uint64_t heap_bytes();
/// Resident memory of this process; 0 where the system does not say.
std::uint64_t resident_bytes();

}  // namespace poise::soak
