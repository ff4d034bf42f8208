// SPDX-License-Identifier: MIT
#include <algorithm>

#include "studies/levels_document.h"

namespace poise::io {
namespace {

// Mean relative error of dv that the method must reach, for levels 1 to 4 and polygons.
constexpr std::array<double, 5> kRoundTargets = {0.45, 0.12, 0.05, 0.03, 0.03};
constexpr std::array<double, 5> kFlatTargets = {0.45, 0.25, 0.14, 0.11, 0.03};
constexpr double kSetback = 0.02;

std::optional<double> target_of(const std::string& group, simulation::ProbeLevel level) {
  const std::size_t place = level.polygons ? 5 : level.level;
  if (place < 1 || place > 5) return std::nullopt;
  if (group == "round") return kRoundTargets[place - 1];
  if (group == "flat") return kFlatTargets[place - 1];
  return std::nullopt;
}

void add(const ErrorSpread& part, ErrorSpread& sum) {
  sum.mean += part.mean;
  sum.median += part.median;
  sum.p90 += part.p90;
}

void divide(double by, ErrorSpread& sum) { sum = {sum.mean / by, sum.median / by, sum.p90 / by}; }

}  // namespace

std::string level_name(simulation::ProbeLevel level) {
  return level.polygons ? "polygons" : std::to_string(static_cast<int>(level.level));
}

std::vector<LevelsSummary> summaries(const LevelsDocument& document) {
  std::vector<LevelsSummary> all;
  for (const char* group : {"round", "flat", "other"}) {
    const std::size_t first = all.size();
    for (const LevelsRow& row : document.rows) {
      if (document.pairs[row.pair].group != group) continue;
      auto at = std::find_if(all.begin() + static_cast<std::ptrdiff_t>(first), all.end(),
                             [&](const LevelsSummary& s) { return s.model == row.model && s.level == row.level; });
      if (at == all.end()) {
        all.push_back({group, row.model, row.level, 0, {}, {}, 0, 0, 0, {}, target_of(group, row.level)});
        at = all.end() - 1;
      }
      ++at->pairs;
      add(row.dv, at->dv);
      add(row.dw, at->dw);
      at->toc_ms_mean += row.toc_ms_mean;
      at->late_share += row.late_share;
      at->unseen_share += row.unseen_share;
      at->cost.refine_ns += row.cost.refine_ns;
      at->cost.overlap_ns += row.cost.overlap_ns;
      at->cost.response_ns += row.cost.response_ns;
    }
  }
  for (LevelsSummary& s : all) {
    const auto pairs = static_cast<double>(s.pairs);
    divide(pairs, s.dv);
    divide(pairs, s.dw);
    for (double* sum :
         {&s.toc_ms_mean, &s.late_share, &s.unseen_share, &s.cost.refine_ns, &s.cost.overlap_ns, &s.cost.response_ns}) {
      *sum /= pairs;
    }
  }
  return all;
}

std::vector<LevelsSetback> setbacks(const LevelsDocument& document) {
  std::vector<LevelsSetback> found;
  for (std::size_t i = 1; i < document.rows.size(); ++i) {
    const LevelsRow& before = document.rows[i - 1];
    const LevelsRow& row = document.rows[i];
    if (before.pair != row.pair || before.model != row.model) continue;
    if (row.dv.mean > before.dv.mean + kSetback + document.pairs[row.pair].uncertainty)
      found.push_back({i, before.dv.mean});
  }
  return found;
}

}  // namespace poise::io
