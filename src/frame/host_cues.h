// SPDX-License-Identifier: MIT
#pragma once

#include "frame/view_cues.h"
#include "poise/scheduler/host_cue.h"

namespace poise::simulation {

/// A pair as a host's cue sees it: what the viewer sees, the pair's number over frames and what the host gave its
/// bodies. `pair` and `view_query` are those that cues_of() was asked with. Any thread.
scheduler::PairView host_view_of(const ViewQuery& view_query, const PairView& pair, std::uint64_t pair_id,
                                 const scheduler::UserData& user_data);

}  // namespace poise::simulation
