// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>

namespace poise::scheduler {

/// Why a frame ended after its deadline. Exclusive, in this order: the mandatory part alone did not fit; the machine
/// took at least as much time away as the frame was late; one job ran longer than forecast by at least as much; all
/// else is the forecast's.
enum class MissCause : std::uint8_t { None, Infeasible, Machine, Overrun, Forecast };

/// What a frame's measured times say about why it was late.
struct LatenessFacts {
  std::chrono::nanoseconds lateness{0};         ///< past the deadline, <= 0 if on time
  std::chrono::nanoseconds mandatory{0};        ///< measured time of everything but refinement, host work included
  std::chrono::nanoseconds budget{0};           ///< from the start of the frame to its deadline
  std::chrono::nanoseconds off_cpu{0};          ///< taken by the machine
  std::chrono::nanoseconds longest_overrun{0};  ///< of a job beyond its forecast
};

/// The cause that these facts show; None for a frame that was on time. Any thread.
MissCause classify(const LatenessFacts& facts);

}  // namespace poise::scheduler
