// SPDX-License-Identifier: MIT
#include "verify/refinement_oracle.h"

#include <algorithm>
#include <queue>
#include <unordered_set>

#include "poise_assert.h"

namespace poise::simulation {
namespace {

// The impulse that b of each active pair received in a frame, N s.
std::vector<Vec3> impulses_of(const PairTable& table, const Manifolds& manifolds, const Velocities& velocities) {
  std::vector<Vec3> impulses(table.size(), Vec3::Zero());
  for (std::size_t m = 0; m < manifolds.manifolds.size(); ++m)
    impulses[manifolds.manifolds[m].pair] = velocities.impulse_ns(m);
  return impulses;
}

struct Candidate {
  double gain = 0, wrong = 0;  // per unit
  std::uint32_t pair = 0;
  // Those that gain by their gain, the others by what is wrong with them; ties by pair, so that the order is the same
  // everywhere.
  bool operator<(const Candidate& other) const {
    const double own = std::max(gain, 0.0);
    const double others = std::max(other.gain, 0.0);
    if (own != others) return own < others;
    return wrong != other.wrong ? wrong < other.wrong : pair > other.pair;
  }
};

}  // namespace

OracleScores::OracleScores(std::span<const std::uint64_t> ids) {
  const auto count = static_cast<double>(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) score_of_.emplace(ids[i], 2 - static_cast<double>(i) / count);
}

scheduler::HostPolicy OracleScores::policy() const {
  // The function only reads.
  return {&OracleScores::score, const_cast<OracleScores*>(this)};
}

double OracleScores::score(const scheduler::FrameFacts&, const scheduler::PairChain& chain, const scheduler::PairCues&,
                           void* context) noexcept {
  const auto& scores = static_cast<const OracleScores*>(context)->score_of_;
  const auto found = scores.find(chain.pair_id);
  return found == scores.end() ? 0 : found->second;
}

void extend(const WorldState& world, const Reference& reference, const View& view, std::span<const std::uint64_t> units,
            std::uint64_t until_units, OracleOrder& order) {
  const Frame& run = world.outputs;
  POISE_ASSERT(units.size() == run.table.size());
  const std::vector<std::uint32_t> of_run = pairs_of_run(run.table, reference.table);
  const std::vector<Vec3> run_ns = impulses_of(run.table, run.manifolds, run.velocities);
  const std::vector<Vec3> full_ns = impulses_of(reference.table, reference.manifolds, reference.velocities);
  const dynamics::BodyStore& bodies = reference.bodies;
  std::vector<Vec3> error_mps(bodies.slot_count(), Vec3::Zero());
  for (std::size_t slot = 0; slot < bodies.slot_count(); ++slot) {
    if (bodies.dynamic[slot] == 0) continue;
    error_mps[slot] = run.velocities.bodies[slot].velocity_mps - reference.velocities.bodies[slot].velocity_mps;
  }
  const auto weight = [&](std::uint32_t slot) {
    if (bodies.dynamic[slot] == 0) return 0.0;
    const double seen = view.present ? reference.weight[slot] : 1.0;
    return seen > 0 ? seen : 0.0;
  };
  const auto candidate = [&](std::uint32_t i) {
    const ActivePair& pair = run.table.pairs[i];
    const Vec3 change_a = -bodies.inverse_mass[pair.a] * (full_ns[of_run[i]] - run_ns[i]);
    const Vec3 change_b = bodies.inverse_mass[pair.b] * (full_ns[of_run[i]] - run_ns[i]);
    const auto fall = [&](std::uint32_t slot, const Vec3& change) {
      return weight(slot) * (error_mps[slot].squaredNorm() - (error_mps[slot] + change).squaredNorm());
    };
    const double wrong = weight(pair.a) * change_a.squaredNorm() + weight(pair.b) * change_b.squaredNorm();
    const auto work = static_cast<double>(units[i]);
    return Candidate{(fall(pair.a, change_a) + fall(pair.b, change_b)) / work, wrong / work, i};
  };
  const std::unordered_set<std::uint64_t> taken(order.ids.begin(), order.ids.end());
  std::priority_queue<Candidate> queue;
  for (std::uint32_t i = 0; i < run.table.size(); ++i) {
    if (units[i] > 0 && !taken.contains(run.table.pairs[i].id())) queue.push(candidate(i));
  }
  while (!queue.empty() && order.units < until_units) {
    const Candidate best = queue.top();
    queue.pop();
    // What was taken since may have changed its bodies.
    const Candidate now = candidate(best.pair);
    if (!queue.empty() && now < best && now < queue.top()) {
      queue.push(now);
      continue;
    }
    const ActivePair& pair = run.table.pairs[best.pair];
    const Vec3 more_ns = full_ns[of_run[best.pair]] - run_ns[best.pair];
    if (bodies.dynamic[pair.a] != 0) error_mps[pair.a] -= bodies.inverse_mass[pair.a] * more_ns;
    if (bodies.dynamic[pair.b] != 0) error_mps[pair.b] += bodies.inverse_mass[pair.b] * more_ns;
    order.ids.push_back(pair.id());
    order.units += units[best.pair];
  }
}

}  // namespace poise::simulation
