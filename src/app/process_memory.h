// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace poise::app {

/// Lets the count of the largest resident memory start again from what is resident now, where the system can (Linux,
/// proc(5)).
void forget_peak_memory();

/// Largest resident memory of this process since it began or since forget_peak_memory, in bytes; 0 where the system
/// does not say.
std::uint64_t peak_memory_bytes();

}  // namespace poise::app
