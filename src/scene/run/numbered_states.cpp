// SPDX-License-Identifier: MIT
#include "scene/run/numbered_states.h"

namespace poise::io {

Status read_states(const SceneRun& run, std::vector<NumberedState>& states) {
  states.clear();
  for (const RunBody& body : run.bodies()) {
    const Result<BodyState> state = run.world().state(body.id);
    if (!state) return state.error();
    states.push_back({body.number, state.value()});
  }
  return Done{};
}

}  // namespace poise::io
