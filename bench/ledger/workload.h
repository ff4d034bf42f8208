// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "poise/result.h"

namespace poise::ledger {

/// A small fixed scene with some counted frames: serial executor, budgets in work units, fixed seeds.
struct Workload {
  std::string_view name;
  std::string_view scene;  ///< a file of bench/ledger/scenes
  /// "polygons", "sleeping", "wrench", "deadline" (one that is an hour away), "deadline, ranked" (where the order
  /// counts all the same) or nothing in addition to the scene; a weight or parameter of the policy that is 1 in the
  /// counted frames, or after "no " one that is 0.
  std::string_view with = "";
  std::uint64_t warm_up = 0;     ///< frames before the counted ones
  std::uint64_t frames = 0;      ///< counted
  std::uint64_t work_units = 0;  ///< of refinement a frame; 0: unlimited
};

std::span<const Workload> workloads();

/// Units of work of the counted frames: sums of FrameReport.
struct CountedUnits {
  double frames = 0;
  double bodies = 0;
  double candidate_pairs = 0;
  double expansions = 0;        ///< of node pairs in refinement; 0 with polygons
  double levels = 0;            ///< completed by refinement
  double contact_pairs = 0;     ///< pairs that were solved
  double point_iterations = 0;  ///< of contact points by the contact solver
};

/// Builds the sphere trees of the scenes that are not cached yet, so that no run under valgrind has to.
Status prepare_trees();

/// Runs a workload. Under callgrind only World::step of the counted frames is counted.
Result<CountedUnits> run_workload(const Workload& workload);

}  // namespace poise::ledger
