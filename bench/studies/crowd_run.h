// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "poise/reference.h"
#include "poise/scene/scene.h"
#include "verify/contact_noise.h"

namespace poise::app {

/// Errors of several frames, of which each has a reference that has converged.
class CrowdErrors {
 public:
  void add(const ReferenceFigures& figures);
  [[nodiscard]] std::size_t frames() const { return e_rel_.size(); }
  /// Median (nearest rank) over the frames of E_rel; and of all bodies of all frames together, sqrt(sum eps^2 / sum
  /// |du*|^2). NaN without frames.
  [[nodiscard]] double median() const;
  [[nodiscard]] double together() const;
  /// Shares of the contacts of the run and of the references; NaN without any.
  [[nodiscard]] double false_share() const;
  [[nodiscard]] double missed_share() const;

 private:
  std::vector<double> e_rel_;
  double error2_ = 0, change2_ = 0;
  std::size_t run_contacts_ = 0, reference_contacts_ = 0, false_ = 0, missed_ = 0;
};

/// The deepest level of a run: one of its trees, or the polygons.
struct CrowdLevel {
  Level max_level = 0;
  bool polygons = false;
};

/// The levels of the deepest tree in a run, from 0, then the polygons.
std::vector<CrowdLevel> levels_of(SceneRun& run);

/// What the frames of one run say.
struct CrowdFrames {
  CrowdErrors whole;                   ///< the step of the run against the reference
  CrowdErrors contacts;                ///< the converged response to contacts of its level against the reference
  CrowdErrors response;                ///< the step against that response
  std::vector<CrowdErrors> disturbed;  ///< converged responses to the reference's contacts with each noise
  std::size_t not_converged = 0;       ///< frames that are in none of these
};

/// Adds the frames of one run, of which each `every`-th is compared, to `into`. Refused: what the run or a step
/// refuses, and Ctrl-C.
Status add_crowd_frames(SceneRun& run, const StepInput& input, const CrowdLevel& level, std::uint64_t frames,
                        std::uint64_t every, std::span<const simulation::ContactNoise> noises,
                        const std::function<void(double share)>& told, CrowdFrames& into);

}  // namespace poise::app
