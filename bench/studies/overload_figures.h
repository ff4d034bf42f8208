// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/run/run_report.h"

namespace poise::simulation {

/// Frames of the same demand, one after another.
struct OverloadStep {
  bool up = true;     ///< on the way from the least demand to the largest; false: on the way back
  double demand = 0;  ///< 1: the work takes all of the budget
};

/// Demands from `least` to `most` by half octaves (the last interval may be shorter), and back in reverse. The largest
/// is held twice: as the end of the way up and as the start of the way back. 0 < least < most.
std::vector<OverloadStep> overload_steps(double least, double most);

/// One step of a drive: figures of the second half of its frames, when the change of the demand is over, but late
/// frames of all.
struct OverloadRow {
  bool up = true;
  double demand = 0;
  std::uint64_t bodies = 0;          ///< dynamic ones, after the last frame
  std::optional<double> level_mean;  ///< over all contact pairs but those by polygons; empty where there is none
  double left_share = 0;             ///< of the pairs whose coarsest spheres overlap: still to be refined
  std::uint64_t frames = 0;          ///< of the whole step
  std::uint64_t infeasible = 0, machine = 0, own = 0;  ///< late frames by cause; own: overrun and forecast
  double p50_ms = 0, p99_ms = 0;
  double held_mean = 0;  ///< bodies that waited, a frame
  double kinetic_j = 0;  ///< mean
  /// Mean potential energy over that of the same frames without a limit; empty where the latter is 0.
  std::optional<double> potential_relative;
  std::optional<double> e_seen_mps;  ///< mean over frames with a reference
};

/// `frames` and `unlimited`: the frames of the step under the budget, and as many of the drive without one.
OverloadRow overload_row(const OverloadStep& step, std::span<const RunFrame> frames,
                         std::span<const RunFrame> unlimited);

/// How far apart the ways up and back are in one figure.
struct OverloadLoop {
  std::string name;                  ///< of the figure
  std::optional<double> difference;  ///< back minus up, the largest in magnitude; empty: at no demand defined for both
  double demand = 0;                 ///< where
};

/// Each figure compared at each demand that both ways have.
std::vector<OverloadLoop> overload_loops(std::span<const OverloadRow> rows);

/// Most by which levels that are back may be below those without a limit. Chosen.
inline constexpr double kLevelBack = 0.02;

/// Whether levels came back after overload.
struct Recovery {
  bool defined = false;  ///< ten frames in a row without a limit have a contact, so there are levels to come back to
  std::optional<std::uint64_t> frames;  ///< before the first ten whose levels are back; empty: none are
};

/// The first ten frames in a row whose mean level is at most kLevelBack below that of the same frames without a limit.
/// Polygons count as one level more than the deepest level of spheres in any of the frames. Ten frames that have no
/// contact without a limit say nothing.
Recovery recovery(std::span<const RunFrame> frames, std::span<const RunFrame> unlimited);

}  // namespace poise::simulation
