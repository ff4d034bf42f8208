// SPDX-License-Identifier: MIT
#include "frame/budget/degrade.h"

#include <algorithm>

#include "poise/scheduler/policy.h"

namespace poise::simulation {
namespace {

// How far two bodies may have moved against each other since, in radii of the smaller one: beyond it, what touched is
// elsewhere.
constexpr double kReusePoints = 1.0;
// A pair that was apart must not sink in so far that it cannot be told from one that passes through. Chosen, as
// kHoldOfSize in coarse.cpp.
constexpr double kReuseApart = 0.5;

bool reusable(const RefineInput& input, const PairProgress& progress, std::size_t index) {
  const ActivePair& pair = input.table.pairs[index];
  const CachedPair& cached = pair.cached;
  // Without a reach nothing was found out, or the caller has moved a body since.
  if (progress.held || progress.cached != CacheUse::None || cached.reach_m <= 0 || !progress.refinable() || progress.exact) return false;
  const BodyBounds& a = input.motion.body_bounds[pair.a];
  const BodyBounds& b = input.motion.body_bounds[pair.b];
  const double radius_m = b.plane ? a.radius_m : std::min(a.radius_m, b.radius_m);
  if (cached.apart) return cached.moved_m <= kReuseApart * radius_m;
  // Balls roll, and the normal that they met with rolls along.
  return cached.level > 0 && cached.point_count > 0 && cached.moved_m <= kReusePoints * radius_m;
}

double seen(const scheduler::Policy& policy, const scheduler::PairCues& cues) {
  // How long a pair has waited says nothing about how well it is seen.
  scheduler::PairCues now = cues;
  now.frames_waited = 0;
  // Nor does what a host thinks of it; and a replay, which has the number of these pairs, chooses them without the
  // host.
  now.host = 1;
  return scheduler::cue_weight(policy, now) * now.angle_radpm;
}

// Those that may be reused, in canonical order, and what they save in all.
double list_reusable(const RefineInput& input, double apart_ns, double points_ns, CompletedLevels& levels) {
  const PairTable& table = input.table;
  levels.least_seen.clear();
  double all_ns = 0;
  for (std::size_t chunk = 0; chunk < table.chunks(); ++chunk) {
    if (table.known_of_chunk[chunk].outdated == 0) continue;
    for (std::size_t i = table.begin_of(chunk); i < table.end_of(chunk); ++i) {
      if (!reusable(input, levels.progress[i], i)) continue;
      levels.least_seen.push_back({seen(input.policy, table.cues[i]), static_cast<std::uint32_t>(i),
                                   table.pairs[i].cached.apart ? apart_ns : points_ns});
      all_ns += levels.least_seen.back().saves_ns;
    }
  }
  return all_ns;
}

void sort_least_seen(std::vector<LeastSeen>& list) {
  std::sort(list.begin(), list.end(), [](const LeastSeen& x, const LeastSeen& y) {
    return x.weight != y.weight ? x.weight < y.weight : x.pair < y.pair;
  });
}

void reuse(const ActivePair& pair, PairProgress& progress, KnownCount& known) {
  progress.cached = pair.cached.apart ? CacheUse::Parted : CacheUse::Expired;
  --known.unknown;
  if (pair.cached.apart) --known.present;
}

}  // namespace

void use_substeps(const RefineInput& input, int substeps, CompletedLevels& levels) {
  if (substeps > 0 && substeps < input.substeps) levels.substeps = substeps;
}

std::size_t pairs_to_reuse(const RefineInput& input, Nanoseconds late, double apart_ns, double points_ns,
                           CompletedLevels& levels) {
  double left_ns = static_cast<double>(late.count());
  const std::vector<LeastSeen>& list = levels.least_seen;
  if (list_reusable(input, apart_ns, points_ns, levels) <= left_ns) return list.size();
  sort_least_seen(levels.least_seen);
  std::size_t count = 0;
  while (count < list.size() && left_ns > 0) left_ns -= list[count++].saves_ns;
  return count;
}

void degrade(const RefineInput& input, const Degraded& degraded, CompletedLevels& levels) {
  use_substeps(input, degraded.substeps, levels);
  if (degraded.pairs_reused == 0) return;
  list_reusable(input, 0, 0, levels);
  const std::size_t count = std::min(degraded.pairs_reused, levels.least_seen.size());
  if (count < levels.least_seen.size()) sort_least_seen(levels.least_seen);
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t pair = levels.least_seen[k].pair;
    reuse(input.table.pairs[pair], levels.progress[pair], levels.known);
  }
}

bool degrade_as_recorded(const RefineInput& input, const FrameDecisions& decisions, CompletedLevels& levels,
                         Degraded& degraded) {
  degraded = {};
  bool there = decisions.substeps < static_cast<std::uint32_t>(input.substeps);
  if (there) degraded.substeps = static_cast<int>(decisions.substeps);
  use_substeps(input, degraded.substeps, levels);
  for (const std::uint32_t index : decisions.reused) {
    if (index >= input.table.size() || !reusable(input, levels.progress[index], index)) {
      there = false;
      continue;
    }
    reuse(input.table.pairs[index], levels.progress[index], levels.known);
    ++degraded.pairs_reused;
  }
  return there;
}

}  // namespace poise::simulation
