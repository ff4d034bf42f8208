// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "poise/decisions.h"
#include "poise/scene/scene.h"
#include "record/record.h"

namespace poise::io {

/// A body as people know it.
struct NamedBody {
  std::size_t index = 0;  ///< place in scene order, as in the table of states
  std::string name;       ///< in the scene, else its shape's
};

/// The bodies of a run by slot; slots without one have an empty name. For one moment: streams add bodies.
std::vector<NamedBody> bodies_by_slot(const Scene& scene, const SceneRun& run);

/// Everything that is known of a frame that was done again.
struct ExplainedFrame {
  RecordedFrame frame;
  FrameExplanation explanation;
  std::vector<NamedBody> bodies;  ///< by slot
  bool wall_clock = true;
};

/// For a person: what was refined, in which order and for which cues, and what was left. At most `limit` rows a list, 0
/// = all.
std::string explain_table(const ExplainedFrame& frame, std::size_t limit);

/// The same as JSON, whole (docs/record.md).
nlohmann::ordered_json explain_json(const ExplainedFrame& frame);

}  // namespace poise::io
