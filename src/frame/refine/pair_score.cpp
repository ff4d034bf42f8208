// SPDX-License-Identifier: MIT
// What the policy knows of a pair, and its score.
#include <algorithm>
#include <array>

#include "frame/cues/known_separation.h"
#include "frame/refine/learned_chain.h"
#include "frame/refine/refine.h"

namespace poise::simulation {

scheduler::FrameFacts frame_facts(const RefineInput& input) {
  scheduler::FrameFacts facts;
  for (const ShapeFacts& shape : input.scene.shapes) {
    if (shape.shape) facts.deepest_level = std::max<std::uint32_t>(facts.deepest_level, shape.shape->tree.depth());
  }
  if (input.terms.polygons) ++facts.deepest_level;
  facts.frame = input.frame;
  facts.seed = input.seed;
  facts.pairs = static_cast<std::uint32_t>(input.table.size());
  return facts;
}

double score_of(const RefineInput& input, const scheduler::FrameFacts& facts, const scheduler::PairCues& cues,
                const PairProgress& progress, const collision::PairContact& found, std::uint32_t index) {
  const ActivePair& pair = input.table.pairs[index];
  const std::size_t deepest = progress.level.deepest;
  ExpectedLevels expected;
  std::array<float, kPolygonBin + 1>& error_m = expected.error_m;
  const auto& error_a = input.scene.facts_of(pair.a).error_m;
  const auto& error_b = input.scene.facts_of(pair.b).error_m;
  for (std::size_t level = 0; level < error_a.size(); ++level) error_m[level] = error_a[level] + error_b[level];
  if (progress.level.polygons) error_m[deepest] = 0;
  const bool learns = input.learned != nullptr && input.policy.learning > 0;
  if (learns) {
    const std::uint32_t shape_a = input.scene.shape_of[pair.a];
    const std::uint32_t shape_b = input.scene.shape_of[pair.b];
    expect_as_learned(input.learned->find(std::min(shape_a, shape_b), std::max(shape_a, shape_b)), input.policy,
                      hazard_by_motion(pair), deepest, expected);
  }
  // What is known of a deeper level, and how far the bodies have moved since. Shallower levels bring nothing more.
  if (progress.has_cached_points() || progress.cached == CacheUse::Parted) {
    const float moved_m = progress.cached == CacheUse::Points ? 0.0F : static_cast<float>(pair.cached->moved_m);
    const float known_m = error_m[progress.cached_level] + moved_m;
    for (std::size_t level = 0; level < progress.cached_level; ++level)
      error_m[level] = std::min(error_m[level], known_m);
  }
  const auto of_levels = [&](const std::array<float, kPolygonBin + 1>& numbers) {
    return std::span<const float>(numbers).first(deepest + 1);
  };
  scheduler::PairChain chain{pair.id(),
                             progress.level.level,
                             of_levels(error_m),
                             progress.level.next_units,
                             user_data_of(input.scene, pair),
                             progress.level.level > 0,
                             pair.cached->level};
  if (learns) {
    chain.lifetime_frames = of_levels(expected.lifetime_frames);
    chain.ended = of_levels(expected.ended);
  }
  if (progress.level.level == 0 || input.policy.touch == 0)
    return scheduler::score(input.policy, facts, chain, cues, index);
  scheduler::PairCues known = cues;
  known.separation = static_cast<float>(found_separation(input.scene, pair, progress.level.level, found));
  return scheduler::score(input.policy, facts, chain, known, index);
}

}  // namespace poise::simulation
