// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "frame/cues/depth_buffer.h"
#include "frame/predict.h"
#include "parallel/executor.h"

namespace poise::simulation {

/// Measures the cue *occlusion*: which bodies are hidden where the step begins. Only what is surely hidden counts: a
/// body whose root sphere is behind what is surely inside others. Invariant: buffers only grow.
struct Occlusion {
  /// Bodies that are drawn, the largest in the image. Chosen: bounds the time.
  static constexpr std::size_t kMostOccluders = 256;

  DepthBuffer depth;
  parallel::UnsetVector<std::uint8_t> hidden;  ///< one a slot: 1 if it is
  bool found = false;                          ///< of this step

  struct Occluder {
    float size = 0;  ///< share of the image's height, of its root sphere
    std::uint32_t slot = 0;
  };
  parallel::UnsetVector<Occluder> occluders;  // scratch
  std::vector<std::size_t> counts;            // scratch
};

/// Fills an Occlusion for the view, which is present.
void find_hidden(const SceneView& scene, const PredictedMotion& motion, const ViewQuery& view_query,
                 Occlusion& occlusion, parallel::Executor& executor);

}  // namespace poise::simulation
