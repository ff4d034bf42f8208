// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

#include "app/compare/compare_loop.h"
#include "scene/compare/comparison_document.h"

namespace poise::app {

/// What states are of, as `poise sweep` has it.
struct StatesIdentity {
  std::string scene_hash;  ///< of the scene and of the files that it names (sweep/trial.h)
  std::string program;     ///< program_identity
};

/// Makes the states once, writes a line of JSON that describes them (`poise.compare-steps/1`), and then answers each
/// line of `in`, which is a policy as --policies has it, with a line: E_seen, E and work of each state and budget, null
/// where a reference has not converged or nothing touched, or `error`. Ends with `in`. `facts` has scene, seed, clock,
/// unit, machine and build; they and `identity` stand in the first line. Refused: what the World refuses, and an output
/// that fails.
Status serve_policies(const Scene& scene, SceneRun& run, const CompareSettings& settings,
                      const io::ComparisonDocument& facts, const StatesIdentity& identity, std::istream& in,
                      const std::function<bool(double share)>& told);

}  // namespace poise::app
