// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>

namespace poise::scheduler {

/// Why a frame ended after its deadline. The causes are exclusive. Release: the frame began at least as late as it
/// ended. The others are tested in this order, by how late it would have been without that delay. Infeasible: the
/// mandatory part alone did not fit into the whole time from release to deadline. Machine: the operating system took at
/// least as much time as the frame was late. Overrun: one job exceeded its forecast by at least as much; Machine if the
/// system took the larger part of that excess. Forecast: all other frames.
enum class MissCause : std::uint8_t { None, Infeasible, Machine, Overrun, Forecast, Release };

/// Measured times of a frame from which the cause is derived.
struct LatenessFacts {
  std::chrono::nanoseconds lateness{0};         ///< past the deadline; <= 0 if on time
  std::chrono::nanoseconds mandatory{0};        ///< measured time of everything but refinement, host work included
  std::chrono::nanoseconds release_delay{0};    ///< from the frame's release to its start, >= 0
  std::chrono::nanoseconds budget{0};           ///< from the release of the frame to its deadline
  std::chrono::nanoseconds off_cpu{0};          ///< time in which the system did not run the thread
  std::chrono::nanoseconds longest_overrun{0};  ///< largest excess of a job over its forecast, without the next
  std::chrono::nanoseconds overrun_off_cpu{0};  ///< what the system took from that job
};

/// The cause that these facts indicate; None for a frame that was on time. Any thread.
MissCause classify(const LatenessFacts& facts);

}  // namespace poise::scheduler
