// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <iosfwd>

#include "app/compare/compare_loop.h"
#include "scene/compare/comparison_document.h"

namespace poise::app {

/// Makes the states once, writes a line of JSON that describes them (`poise.compare-steps/1`), and then answers each
/// line of `in`, which is a policy as --policies has it, with a line: E_seen, E and work of each state and budget, null
/// where a reference has not converged or nothing touched, or `error`. Ends with `in`. `facts` has scene, seed, clock,
/// unit, machine and build. Refused: what the World refuses, and an output that fails.
Status serve_policies(const Scene& scene, SceneRun& run, const CompareSettings& settings,
                      const io::ComparisonDocument& facts, std::istream& in,
                      const std::function<bool(double share)>& told);

}  // namespace poise::app
