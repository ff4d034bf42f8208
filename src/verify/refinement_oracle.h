// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "verify/reference.h"

namespace poise::simulation {

/// Scores of pairs by what refining them is worth, for a Policy of kind Custom. `context` of the policy points to it.
class OracleScores {
 public:
  /// The first pair of `ids` is served first; what is not listed is refined last.
  explicit OracleScores(std::span<const std::uint64_t> ids);
  [[nodiscard]] scheduler::HostPolicy policy() const;

 private:
  static double score(const scheduler::FrameFacts& frame, const scheduler::PairChain& chain,
                      const scheduler::PairCues& cues, void* context) noexcept;
  std::unordered_map<std::uint64_t, double> score_of_;
};

/// The order in which an offline oracle refines pairs, as far as it is known.
struct OracleOrder {
  std::vector<std::uint64_t> ids;  ///< PairChain::pair_id
  std::uint64_t units = 0;         ///< work of refining these to their end
};

/// Goes on with `order` until it holds `until_units` of work, or all pairs. `world` has just done a frame in which the
/// pairs of `order` were refined and no others, `reference` is that of this frame, compared with `view`, and units[i]
/// is the work of refining the i-th active pair to its end; 0 if there is nothing to refine.
///
/// The gain of a pair is the fall of sum s eps^2 (the sum in E_seen) when that pair alone is refined, per unit of work;
/// the best one is taken, its bodies change by what it gave, and so on. Where none gains, those come first whose
/// impulse is most wrong, in the same unit. Approximation: refined alone, a pair would give the impulse that it has in
/// the reference, its bodies would change by that impulse over their mass, and no other impulse would change. Only
/// linear velocities count.
void extend(const WorldState& world, const Reference& reference, const View& view, std::span<const std::uint64_t> units,
            std::uint64_t until_units, OracleOrder& order);

}  // namespace poise::simulation
