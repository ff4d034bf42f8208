// SPDX-License-Identifier: MIT
#include "frame/pair_progress.h"

namespace poise::simulation {

PairOutcome outcome_of(const PairProgress& progress) {
  if (progress.cached == CacheUse::Separated) return PairOutcome::KnownApart;
  if (progress.exact) return PairOutcome::Mandatory;
  if (progress.level.apart) return PairOutcome::FoundApart;
  if (!progress.refinable()) {
    const bool known = progress.cached == CacheUse::Points && progress.level.level == 0;
    return known ? PairOutcome::KnownPoints : PairOutcome::Deepest;
  }
  if (progress.stop == Stop::Reused && progress.level.level == 0) return PairOutcome::Reused;
  if (progress.stop == Stop::Cut) return PairOutcome::CutOff;
  if (progress.full) return PairOutcome::FrontFull;
  return progress.stop == Stop::Unseen ? PairOutcome::Unseen : PairOutcome::Unserved;
}

}  // namespace poise::simulation
