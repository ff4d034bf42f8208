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
  if (progress.held || progress.cached != CacheUse::None || cached.reach_m <= 0 || !progress.refinable() ||
      progress.exact)
    return false;
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

// Brings the least seen ones that save so much to the front, in no order among themselves, and returns how many they
// are.
std::size_t select_least_seen(double left_ns, std::vector<LeastSeen>& list) {
  const auto at = [&](std::size_t i) { return list.begin() + static_cast<std::ptrdiff_t>(i); };
  const auto less_seen = [](const LeastSeen& x, const LeastSeen& y) {
    return x.weight != y.weight ? x.weight < y.weight : x.pair < y.pair;
  };
  std::size_t taken = 0;
  std::size_t end = list.size();
  while (taken < end && left_ns > 0) {
    const std::size_t middle = taken + (end - taken + 1) / 2;
    if (middle < end) std::nth_element(at(taken), at(middle), at(end), less_seen);
    double half_ns = 0;
    for (std::size_t i = taken; i < middle; ++i) half_ns += list[i].saves_ns;
    if (half_ns > left_ns && middle - taken > 1) {
      end = middle;
      continue;
    }
    left_ns -= half_ns;
    taken = middle;
  }
  return taken;
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
  const auto left_ns = static_cast<double>(late.count());
  if (list_reusable(input, apart_ns, points_ns, levels) <= left_ns) return levels.least_seen.size();
  return select_least_seen(left_ns, levels.least_seen);
}

void degrade(const RefineInput& input, const Degraded& degraded, CompletedLevels& levels) {
  use_substeps(input, degraded.substeps, levels);
  for (std::size_t k = 0; k < std::min(degraded.pairs_reused, levels.least_seen.size()); ++k) {
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
