// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/front/pair_frame.h"
#include "frame/ccd/swept_state.h"
#include "frame/step_terms.h"
#include "parallel/executor.h"
#include "parallel/unset_vector.h"
#include "world/scene_view.h"

/// Stage *predict*: where bodies are, and where they may come to during the step.
namespace poise::simulation {

// Gaps below this share of the smaller body count as touching. Chosen: half a percent is below what a coarse level can
// tell apart, and keeps resting contacts from flickering.
inline constexpr double kSkin = 5e-3;

struct PredictInput {
  SceneView scene;
  StepTerms terms;
};

/// What finding pairs reads of a body, side by side: two cache lines.
struct alignas(64) BodyBounds {
  Vec3 position_m = Vec3::Zero();  ///< of a plane: its normal
  double bound_m = 0;  ///< radius of a ball that holds the body wherever it may be in the step; of a plane: its height
  Vec3 root_center_m = Vec3::Zero();  ///< of the root sphere
  double root_radius_m = 0;
  Vec3 velocity_mps = Vec3::Zero();
  double estimated_radius_m =
      0;             ///< of the ball about the root's centre whose surface is likely that of the body; may be negative
  double own_m = 0;  ///< by how much its surface may move beyond what velocity and gravity do
  double radius_m = 0;
  bool plane = false, dynamic = false;
  bool meshed = false;  ///< its shape has a surface of polygons
  /// Place in a pair: a ball about its centre of mass comes before what is neither, and that before a plane.
  enum class Place : std::uint8_t { Ball, Between, Plane };
  Place place = Place::Between;
  Level depth = 0;  ///< of its tree; 0 of a plane
};
static_assert(sizeof(BodyBounds) == 128);

/// Output of *predict*. What it says of a body that rests holds until the body is changed. Invariant: buffers only
/// grow.
struct PredictedMotion {
  bool everything = true;              ///< nothing is known yet: the next step looks at all bodies
  std::vector<std::uint32_t> visited;  ///< slots of bodies that move, or were changed since the last step; ascending
  parallel::UnsetVector<collision::Pose> poses;          ///< one a slot, at the start of the step
  parallel::UnsetVector<BodyBounds> body_bounds;         ///< one a slot
  parallel::UnsetVector<Mat3> inverse_inertia;           ///< one a slot, world frame
  parallel::UnsetVector<Vec3> spins_radps;               ///< one a slot, at the start of the step
  parallel::UnsetVector<collision::MotionBound> bounds;  ///< of bodies that move, and are not swept
  std::vector<collision::PlaneBound> planes;
  bool planes_changed = true;
  SweptBounds swept;  ///< with StepTerms::backtracking: of the bodies that move far

  std::vector<std::size_t> counts;  // scratch
};

/// What the broad phase asks of a body, once it is predicted.
collision::MotionBound motion_bound_of(const SceneView& scene, const PredictedMotion& motion, std::uint32_t slot);

void predict(const PredictInput& input, PredictedMotion& motion, parallel::Executor& executor);

}  // namespace poise::simulation
