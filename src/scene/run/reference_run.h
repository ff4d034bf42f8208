// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "poise/reference.h"
#include "scene/run/percentiles.h"

namespace poise::simulation {

/// Statistics of the references of a run: percentiles over the frames in which a figure is defined; empty if there is
/// none. A reference that has not converged is counted, and in no figure but `iterations` and `time_ms`.
struct ReferenceRunFigures {
  std::uint64_t frames = 0;            ///< number with a reference
  std::uint64_t not_converged = 0;     ///< number of these frames
  std::uint64_t pairs_not_finest = 0;  ///< sum over the frames
  std::optional<Percentiles> e_mps, e_rel, e_seen_mps;
  std::optional<Percentiles> gap_mean_mm, gap_max_mm, gap_mean_px, gap_max_px;
  std::optional<Percentiles> false_rate, missed_rate;  ///< of single frames
  std::optional<Percentiles> bodies_touched, iterations, time_ms;
  std::uint64_t run_contacts = 0, reference_contacts = 0, false_contacts = 0, missed_contacts = 0, contacts_apart = 0;
  std::optional<double> false_share, missed_share;  ///< of the contacts of all frames together
};

/// Computes the statistics; `frames` in their order.
ReferenceRunFigures reference_run_figures(std::span<const ReferenceFigures> frames);

}  // namespace poise::simulation
