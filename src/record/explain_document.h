// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "poise/decisions.h"
#include "poise/scene/scene.h"
#include "record/record.h"

namespace poise::io {

/// A body with its name.
struct NamedBody {
  std::uint64_t number = 0;  ///< RunBody::number, as in the table of states
  std::string name;          ///< name in the scene, or else of its shape
};

/// The bodies of a run by slot; slots without a body have an empty name. Valid until stream bodies come or leave.
std::vector<NamedBody> bodies_by_slot(const Scene& scene, const SceneRun& run);

/// All data of a frame that was replayed.
struct ExplainedFrame {
  RecordedFrame frame;
  FrameExplanation explanation;
  std::vector<NamedBody> bodies;  ///< by slot
  bool wall_clock = true;
};

/// A text table: which pairs were refined, in which order and with which cues, and which were left. At most `limit`
/// rows a list; 0 = all.
std::string explain_table(const ExplainedFrame& frame, std::size_t limit);

/// The same as JSON, without a limit (docs/record.md).
nlohmann::ordered_json explain_json(const ExplainedFrame& frame);

}  // namespace poise::io
