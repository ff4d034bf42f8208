// SPDX-License-Identifier: MIT
#include "studies/order_figures.h"

#include <algorithm>
#include <vector>

namespace poise::app {
namespace {

// A level of a pair. A sorted queue comes to it when it has come to all that score more than `turn`: the lowest score
// of the pair's levels up to this one, because a level has its turn only after those before it.
struct Turn {
  double turn = 0;
  std::uint64_t units = 0;
  bool done = false;
};

std::vector<Turn> turns_of(const FrameDecisions& decisions, const FrameExplanation& all) {
  std::vector<std::uint32_t> completed(all.pairs.size(), 0);
  for (const RefinementStep& step : decisions.steps) {
    if (step.kind == RefinementStep::Kind::Completed && step.pair < completed.size()) ++completed[step.pair];
  }
  std::vector<Turn> turns;
  turns.reserve(all.levels.size());
  std::uint32_t of_pair = 0;
  for (std::size_t i = 0; i < all.levels.size(); ++i) {
    const LevelExplanation& level = all.levels[i];
    const bool first = i == 0 || all.levels[i - 1].pair != level.pair;
    of_pair = first ? 1 : of_pair + 1;
    const double turn = first ? level.score : std::min(turns.back().turn, level.score);
    turns.push_back({turn, level.units, of_pair <= completed[level.pair]});
  }
  return turns;
}

}  // namespace

OrderFigures order_figures(const FrameDecisions& done, const FrameExplanation& all) {
  std::vector<Turn> turns = turns_of(done, all);
  OrderFigures figures;
  for (const Turn& turn : turns) {
    figures.full += turn.units;
    if (turn.done) figures.done += turn.units;
  }
  // Among equals those that were done come first: no order is wrong there.
  std::stable_sort(turns.begin(), turns.end(),
                   [](const Turn& a, const Turn& b) { return a.turn != b.turn ? a.turn > b.turn : a.done && !b.done; });
  std::uint64_t taken = 0;
  for (const Turn& turn : turns) {
    if (taken < figures.done) {
      taken += turn.units;
    } else if (turn.done) {
      figures.misplaced += turn.units;
    }
  }
  return figures;
}

}  // namespace poise::app
