// SPDX-License-Identifier: MIT
#include "solver/contact_solver.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "collision/manifold/manifold_point.h"
#include "parallel/ranges.h"
#include "solver/contacts/angular_balance.h"
#include "solver/contacts/contact_blocks.h"
#include "solver/contacts/flight.h"
#include "solver/contacts/prefetch_blocks.h"
#include "solver/contacts/split_system.h"
#include "solver/contacts/substep.h"
#include "solver/iterations/anderson_mixing.h"
#include "solver/iterations/energy_guard.h"
#include "solver/iterations/impulse_lanes.h"
#include "solver/iterations/iteration_change.h"
#include "solver/iterations/iteration_limit.h"
#include "solver/iterations/iteration_stop.h"
#include "solver/iterations/iteration_threads.h"
#include "solver/iterations/settling.h"

namespace poise::solver {
namespace {

// No more iterations once one changes no approach speed by more than this share of the rest speed.
constexpr double kSettledOfStill = 3e-5;
// Far from the solution: the changes of approach speeds, weighted by impulses, are above this share of the rest speed.
constexpr double kFarOfStill = 0.01;
// An extrapolation step diverged if the bodies in contact then have this many times the energy that they had, or would
// have without contacts.
constexpr double kDiverged = 2;
// How many blocks ahead what they read is prefetched.
constexpr std::size_t kPairsAhead = 3, kAhead = 1;
// Of loops that do no more than look at them.
constexpr std::size_t kBlocksAtOnce = 16;
// With as many iterations in a substep, or more, threads are used only if they pay.
constexpr std::uint32_t kManyIterations = 8;

}  // namespace

struct ContactSolver::Buffers {
  parallel::UnsetVector<ContactBlock> blocks;
  std::vector<std::size_t> block_begin;          // per colour, then the end
  std::vector<std::size_t> lanes_of_range;       // scratch of make_blocks
  std::vector<IterationChange<double>> changes;  // one a block, where iterations converge
  BodyCopies copies;
  IterationStop stop;
  AndersonMixing mixing;
  Settling settling;
  // Of all impulses that are iterated, in the order of impulse_lanes.h: the root of the mass that each moves, and the
  // impulses times these, whose squares are energies.
  std::vector<double> roots, before, after;
  std::vector<double> swept;  // impulses of all lanes after the last plain iteration
  EnergyGuard energy;
  bool keeps_totals = false;
  bool distant = false;  // what the pairs name is in no cache near by: it is prefetched
  // Each precision by itself: their iterations take different times.
  IterationThreads single_threads, twofold_threads;
  double alone_j = 0;  // of this substep without contacts; contacts only reduce it
  LaneMemories memory;
  Lanes<float> single;
  Lanes<double> twofold;

  template <class T>
  Lanes<T>& lanes() {
    if constexpr (sizeof(T) == sizeof(float)) {
      return single;
    } else {
      return twofold;
    }
  }

  template <class T>
  IterationThreads& threads() {
    return sizeof(T) == sizeof(float) ? single_threads : twofold_threads;
  }

  std::size_t make_blocks(const SplitSystem& system, parallel::Executor& executor);
  // All blocks, colour by colour; on the calling thread if `alone`.
  template <class Visit>
  void iteration(bool alone, parallel::Executor& executor, Visit&& visit);
  template <class Visit>
  void for_impulses(Visit&& visit);
  // Calls visit(block, where its numbers begin) for each block; returns how many there are.
  template <class Visit>
  std::size_t for_numbers(Visit&& visit);
  std::size_t find_roots();
  void read_impulses(std::vector<double>& into);
  void mix(const SplitSystem& system, parallel::Executor& executor);
  void take_back(const SplitSystem& system, double h_s, parallel::Executor& executor);
  template <class T>
  void reserve(const SplitSystem& system, bool mixed, bool keeps, parallel::Executor& executor);
  template <class T>
  void fill(const SplitSystem& system, const BlockTerms& terms, Lanes<T>& all, parallel::Executor& executor);
  template <class T, class Apply>
  Iterated iterate(const Iterating<T>& how, bool last_substep, Apply&& apply, Convergence& ended,
                   parallel::Executor& executor);
  // Returns angular momentum that pairs took or added (angular_balance.h).
  template <class T>
  void balance(const SplitSystem& system, parallel::Executor& executor);
  // Nothing where the limit says only_collisions, and there are none: then nothing was changed either.
  template <class T>
  std::optional<Convergence> solve(const SplitSystem& system, const SolveSettings& settings,
                                   const IterationLimit& limit, parallel::Executor& executor);
};

// Calls visit(block has friction, lanes of the pairs, lanes of the contact point, lane) for every contact point of
// every pair.
template <class Visit>
void ContactSolver::Buffers::for_impulses(Visit&& visit) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (PointLanes<double>& point : twofold.manifold_points_of(blocks[i])) {
      for (std::size_t lane = 0; lane < blocks[i].count; ++lane)
        visit(blocks[i].frictional, twofold.pairs[i], point, lane);
    }
  }
}

// Returns how many there are.
std::size_t ContactSolver::Buffers::find_roots() {
  std::size_t at = 0;
  const auto root_of = [](double reduced_mass, double mass) { return mass > 0 ? std::sqrt(reduced_mass / mass) : 0.0; };
  for_impulses(
      [&](bool frictional, const PairLanes<double>& shared, const PointLanes<double>& point, std::size_t lane) {
        roots[at++] = root_of(shared.reduced_mass[lane], point.mass[lane]);
        const double across = root_of(shared.reduced_mass[lane], point.across[lane]);
        for (std::size_t k = 0; k < 3 && frictional; ++k) roots[at++] = across;
      });
  return at;
}

template <class Visit>
std::size_t ContactSolver::Buffers::for_numbers(Visit&& visit) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    visit(i, at);
    at += impulse_numbers(blocks[i]);
  }
  return at;
}

void ContactSolver::Buffers::read_impulses(std::vector<double>& into) {
  for_numbers([&](std::size_t i, std::size_t at) {
    list_impulses(blocks[i], twofold.manifold_points_of(blocks[i]), &roots[at], &into[at]);
  });
}

// Extrapolates from the last iterations, clamped to the friction cones; undone if it adds energy. `before` then has the
// impulses of the next iteration.
void ContactSolver::Buffers::mix(const SplitSystem& system, parallel::Executor& executor) {
  read_impulses(after);
  if (!mixing.mix(before, after)) {
    std::swap(before, after);
    return;
  }
  const double swept_j = energy.joules(twofold.motions);
  energy.keep(twofold.motions);
  const std::size_t numbers = for_numbers([&](std::size_t i, std::size_t at) {
    change_impulses(blocks[i], twofold.pairs[i], twofold.manifold_points_of(blocks[i]), &roots[at], &after[at],
                    &swept[at]);
  });
  iteration(twofold_threads.alone(), executor, [&](std::size_t i) {
    warm_start_block(blocks[i], twofold.pairs[i], twofold.manifold_points_of(blocks[i]), twofold.bodies());
  });
  join_motions(system, twofold.motions, executor);
  const bool diverged = !(energy.joules(twofold.motions) <= kDiverged * std::max(swept_j, alone_j));
  if (diverged) {
    energy.restore(twofold.motions);
    join_motions(system, twofold.motions, executor);
    mixing.begin(numbers);
  }
  const std::vector<double>& impulses = diverged ? swept : after;
  for_numbers([&](std::size_t i, std::size_t at) {
    set_impulses(blocks[i], twofold.manifold_points_of(blocks[i]), &impulses[at], &roots[at], &before[at]);
  });
}

// Contact points that separate under their impulse add energy. Scales all impulses down to the share that adds none.
void ContactSolver::Buffers::take_back(const SplitSystem& system, double h_s, parallel::Executor& executor) {
  const double share = energy.best_share(system, twofold.begun, h_s, twofold.motions);
  if (share == 1) return;
  energy.scale(system, twofold.begun, h_s, share, twofold.motions);
  join_motions(system, twofold.motions, executor);
  for_impulses([&](bool frictional, const PairLanes<double>&, PointLanes<double>& point, std::size_t lane) {
    point.impulse[lane] *= share;
    for (std::size_t k = 0; k < 3 && frictional; ++k) point.friction_impulse[k][lane] *= share;
  });
}

// Makes blocks of the pairs, colour by colour, in the order of the rows (coloring.h). Returns how many lanes of contact
// points they need.
std::size_t ContactSolver::Buffers::make_blocks(const SplitSystem& system, parallel::Executor& executor) {
  constexpr std::size_t kLeast = 128;
  const Coloring& coloring = system.coloring;
  const auto pairs_begin = [&](std::size_t color) { return coloring.begin(static_cast<std::uint32_t>(color)); };
  block_begin.reserve(2 * kColors + 1);
  block_begin.assign(1, 0);
  for (std::size_t color = 0; color < coloring.colors(); ++color) {
    const std::size_t pairs = pairs_begin(color + 1) - pairs_begin(color);
    block_begin.push_back(block_begin.back() + (pairs + kLanes - 1) / kLanes);
  }
  blocks.resize(block_begin.back());
  const parallel::Ranges ranges(blocks.size(), kLeast);
  lanes_of_range.reserve(parallel::Ranges::kMost);
  lanes_of_range.assign(ranges.count, 0);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    std::size_t color = 0;
    std::size_t lanes = 0;
    for (std::size_t i = begin; i < end; ++i) {
      while (block_begin[color + 1] <= i) ++color;
      ContactBlock& block = blocks[i];
      block = ContactBlock{};
      const std::size_t first = pairs_begin(color) + (i - block_begin[color]) * kLanes;
      block.begin = static_cast<std::uint32_t>(first);
      block.count = static_cast<std::uint8_t>(std::min(kLanes, pairs_begin(color + 1) - first));
      for (const std::uint32_t pair : coloring.order().subspan(first, block.count))
        block.manifold_points = std::max(block.manifold_points, system.solved_points(pair));
      lanes += block.manifold_points;
    }
    lanes_of_range[range] = lanes;
  });
  std::size_t sum = 0;
  for (std::size_t& lanes : lanes_of_range) lanes = std::exchange(sum, sum + lanes);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    std::size_t lanes = lanes_of_range[range];
    for (std::size_t i = begin; i < end; ++i) {
      blocks[i].first = static_cast<std::uint32_t>(lanes);
      lanes += blocks[i].manifold_points;
    }
  });
  return sum;
}

template <class Visit>
void ContactSolver::Buffers::iteration(bool alone, parallel::Executor& executor, Visit&& visit) {
  constexpr std::size_t kGrain = 4;
  constexpr std::size_t kAloneGrain = 64;
  if (alone) {
    parallel::serial_for(executor, blocks.size(), kAloneGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) visit(i);
    });
    return;
  }
  for (std::size_t color = 0; color + 1 < block_begin.size(); ++color) {
    const std::size_t first = block_begin[color];
    parallel::parallel_for(executor, block_begin[color + 1] - first, kGrain,
                           [&](std::size_t begin, std::size_t end, int) {
                             for (std::size_t i = first + begin; i < first + end; ++i) visit(i);
                           });
  }
}

template <class T>
void ContactSolver::Buffers::reserve(const SplitSystem& system, bool mixed, bool keeps, parallel::Executor& executor) {
  constexpr std::size_t kGrain = 512;
  Lanes<T>& all = lanes<T>();
  const std::size_t needed = make_blocks(system, executor);
  LaneMemory& of_points = system.memory != nullptr ? *system.memory : memory.manifold_points;
  all.manifold_points = of_points.use_anew<PointLanes<T>>(needed);
  keeps_totals = keeps;
  distant = system.pairs.size() > parallel::kPairsAtHand;
  if (keeps) all.totals = memory.totals.use_anew<TotalLanes<T>>(needed);
  all.pairs = memory.pairs.use_anew<PairLanes<T>>(blocks.size());
  const std::size_t bodies = system.bodies.size();
  const std::size_t known = std::exchange(all.known, bodies);
  const std::size_t motions = system.motions();
  all.motions = memory.motions.use<MotionChange<T>>(motions, executor);
  all.begun = memory.begun.use<SpeedChange<T>>(motions, executor);
  all.scaled_inverse_inertias = memory.scaled_inverse_inertias.use<ScaledInverseInertia<T>>(motions, executor);
  // New bodies may be at rest. After a step in the other precision all are written, whatever they hold.
  if (all.used_last && bodies > known) {
    parallel::parallel_for(executor, bodies - known, kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = known + begin; i < known + end; ++i) {
        all.motions[i] = {};
        all.begun[i] = {};
        all.scaled_inverse_inertias[i] = {};
      }
    });
  }
  if (mixed) {
    roots.resize(std::max(roots.size(), 4 * kLanes * needed + kNumbersBeyond));
    before.resize(roots.size());
    after.resize(before.size());
    swept.resize(before.size());
  }
  changes.resize(blocks.size());
}

// Brings the contact points to the lanes, and their impulses of the last step to the bodies.
template <class T>
void ContactSolver::Buffers::fill(const SplitSystem& system, const BlockTerms& terms, Lanes<T>& all,
                                  parallel::Executor& executor) {
  const BodyLanes<T> bodies = all.bodies();
  iteration(threads<T>().alone(), executor, [&](std::size_t i) {
    if (distant && i + kPairsAhead < blocks.size()) prefetch_pairs(system, blocks[i + kPairsAhead]);
    if (distant && i + kAhead < blocks.size()) prefetch_points(system, blocks[i + kAhead]);
    fill_block(system, terms, blocks[i], all.pairs[i], all);
    warm_start_block(blocks[i], all.pairs[i], all.manifold_points_of(blocks[i]), bodies);
  });
  join_motions(system, all.motions, executor);
}

// The iterations of one substep. `apply` hands a block's impulses over: here in the last substep, while its lanes are
// at hand, where nothing is watched.
template <class T, class Apply>
Iterated ContactSolver::Buffers::iterate(const Iterating<T>& how, bool last_substep, Apply&& apply, Convergence& ended,
                                         parallel::Executor& executor) {
  const auto& [system, settings, limit, substep_terms] = how;
  SubstepTerms<T> terms = substep_terms;
  Lanes<T>& all = lanes<T>();
  const BodyLanes<T> bodies = all.bodies();
  Iterated result;
  result.reached = !settings.stopping.converges();
  stop.begin_substep();
  MeanChange mean;
  settling.begin();
  if (limit.mixed) {
    mixing.begin(find_roots());
    alone_j = energy.joules_alone(system, twofold.begun, settings.dt_s / settings.substeps);
  }
  for (std::uint32_t round = 0;; ++round) {
    ++ended.iterations;
    if (limit.mixed && round == 0) read_impulses(before);
    const bool measures = threads<T>().measures();
    const auto begun = measures ? executor.time() : std::chrono::steady_clock::time_point{};
    iteration(threads<T>().alone(), executor, [&](std::size_t i) {
      std::array<TotalLanes<T>, collision::kMaxManifoldPoints> here;
      const std::span<TotalLanes<T>> totals =
          keeps_totals ? all.totals_of(blocks[i]) : std::span(here).first(blocks[i].manifold_points);
      if (distant && i + 1 < blocks.size()) prefetch_motions(bodies, blocks[i + 1]);
      const IterationChange<T> change =
          solve_block(blocks[i], {all.pairs[i], all.manifold_points_of(blocks[i]), totals}, terms, round, bodies);
      if (terms.watch) changes[i] = widened(change);
      if (last_substep && !terms.watch) apply(i, totals);
    });
    join_motions(system, all.motions, executor);
    if (measures) threads<T>().note(executor.time() - begun);
    if (!terms.watch) break;
    const IterationChange<double> sum = sum_of(changes);
    result.far = sum.residual_j > kFarOfStill * still_mps(settings) * sum.impulse_sum_ns;
    if (settings.stopping.converges()) {
      const Stopping& stopping = settings.stopping;
      result.settled = result.reached =
          sum.change_ns <= stopping.share * sum.largest_ns ||
          (stopping.settled_share > 0 &&
           settling.settled(system, twofold.motions.first(system.bodies.size()), twofold.begun,
                            static_cast<double>(terms.h_s), round + 1, stopping.settled_share));
    } else {
      mean.add(sum.impulse_sum_ns > 0 ? sum.residual_j / sum.impulse_sum_ns : 0.0, still_mps(settings));
      result.settled = sum.change_mps <= kSettledOfStill * still_mps(settings) || (limit.by_mean && mean.settled());
    }
    result.collision = mean.collides();
    if (limit.only_collisions && !result.collision) break;
    if (result.settled || round + 1 >= limit.iterations(result.far)) break;
    result.stopped = stop.stops(round);
    // A plain iteration comes last.
    if (result.stopped) break;
    if (limit.mixed) {
      mix(system, executor);
    } else if (limit.by_mean && result.collision) {
      terms.relaxation = static_cast<T>(kCollisionRelaxation);
    }
  }
  stop.end_substep();
  return result;
}

template <class T>
void ContactSolver::Buffers::balance(const SplitSystem& system, parallel::Executor& executor) {
  const Lanes<T>& all = lanes<T>();
  parallel::parallel_for(executor, blocks.size(), kBlocksAtOnce, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) measure_angular_change(system, blocks[i], all.pairs[i]);
  });
  iteration(threads<T>().alone(), executor,
            [&](std::size_t i) { return_angular_momentum(system, blocks[i], all.pairs[i]); });
  join_velocities(system, executor);
}

template <class T>
std::optional<Convergence> ContactSolver::Buffers::solve(const SplitSystem& system, const SolveSettings& settings,
                                                         const IterationLimit& limit, parallel::Executor& executor) {
  constexpr std::size_t kGrain = 512;
  const IterationLimit full = limit.only_collisions ? limit : limit_of(system, settings, kMaxPointIterations);
  const double h_s = settings.dt_s / settings.substeps;
  const bool watch = limit.most > 1;
  reserve<T>(system, limit.mixed, watch || settings.substeps > 2, executor);
  Lanes<T>& all = lanes<T>();
  threads<T>().begin(limit.most >= kManyIterations && executor.concurrency() > 1);
  // Lanes that were not used in the last step do not know what rests.
  const bool everything = !std::exchange(all.used_last, true) || !system.only_active;
  (std::is_same_v<T, float> ? twofold.used_last : single.used_last) = false;
  const std::size_t looked_at = everything ? system.bodies.size() : system.active.size();
  const auto for_bodies = [&](auto&& visit) {
    parallel::parallel_for(executor, looked_at, kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) visit(everything ? k : system.active[k]);
    });
    parallel::parallel_for(executor, system.copies.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) visit(system.bodies.size() + k);
    });
  };
  const auto for_blocks = [&](auto&& visit) {
    parallel::parallel_for(executor, blocks.size(), kBlocksAtOnce, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) visit(i);
    });
  };
  for_bodies([&](std::size_t i) {
    all.motions[i] = MotionChange<T>{};
    all.scaled_inverse_inertias[i] = scaled_inverse_inertia<T>(system.body(i), system.inverse_inertia_of(i));
    system.body(i).pulled = !system.acceleration_of(i).none();
    begin_substep(system, i, h_s, true, all);
  });
  fill(system, {still_mps(settings), settings.dt_s, h_s}, all, executor);
  if (limit.mixed) energy.begin(system, blocks);
  const SubstepTimes times = {h_s, settings.dt_s - h_s, still_mps(settings)};
  const auto give = [&](std::size_t i, std::span<const TotalLanes<T>> totals) {
    if (distant && i + kPairsAhead < blocks.size()) prefetch_pairs(system, blocks[i + kPairsAhead]);
    if (distant && i + kAhead < blocks.size()) prefetch_results(system, blocks[i + kAhead]);
    write_back_block(system, times, blocks[i], all.pairs[i],
                     std::span<const PointLanes<T>>(all.manifold_points_of(blocks[i])), totals);
  };
  SubstepTerms<T> terms = terms_of<T>(settings, watch);
  terms.relaxation = static_cast<T>(first_relaxation(system, settings, limit));
  stop.begin(settings, executor);
  Convergence ended;
  for (int substep = 0; substep < settings.substeps; ++substep) {
    terms.begun_s = static_cast<T>(substep * h_s);
    const bool last = substep + 1 == settings.substeps;
    terms.totals = totals_in(substep, settings.substeps);
    for_bodies([&](std::size_t i) {
      if (substep > 0) {
        end_substep(i, h_s, all);
        begin_substep(system, i, h_s, false, all);
      }
      if (last) fly(system, i, settings.dt_s);
    });
    IterationLimit limit_here = limit;
    limit_here.only_collisions = limit.only_collisions && substep == 0;
    const Iterated done = iterate(Iterating<T>{system, settings, limit_here, terms}, last, give, ended, executor);
    if (limit_here.only_collisions && !done.collision) return std::nullopt;
    if (limit.mixed && !done.settled && done.far) take_back(system, h_s, executor);
    if (watch) for_blocks([&](std::size_t i) { add_totals(blocks[i], substep == 0, all); });
    if (substep > 0 && !last)
      for_blocks([&](std::size_t i) {
        add_late_impulses<T>(blocks[i], substep * h_s, all.pairs[i], all.manifold_points_of(blocks[i]));
      });
    ended.reached = ended.reached && done.reached;
    ended.cut_short =
        ended.cut_short || done.stopped || (!done.settled && limit.iterations(done.far) < full.iterations(done.far));
  }
  ended.point_iterations = ended.iterations * system.point_count * (limit.mixed ? kMixedIterationCost : 1U);
  for_bodies([&](std::size_t i) {
    end_substep(i, h_s, all);
    land(all.motions[i], system.body(i));
  });
  if (watch) iteration(threads<T>().alone(), executor, [&](std::size_t i) { give(i, all.totals_of(blocks[i])); });
  join_velocities(system, executor);
  if (std::ranges::any_of(blocks, [](const ContactBlock& block) { return block.shifted != 0; }))
    balance<T>(system, executor);
  return ended;
}

const IterationsMade& ContactSolver::made() const { return buffers_->stop.outcome(); }

ContactSolver::ContactSolver() : buffers_(std::make_unique<Buffers>()) {}
ContactSolver::~ContactSolver() = default;
ContactSolver::ContactSolver(ContactSolver&&) noexcept = default;
ContactSolver& ContactSolver::operator=(ContactSolver&&) noexcept = default;

Convergence ContactSolver::solve(const ContactSystem& whole, const SolveSettings& settings,
                                 parallel::Executor& executor) {
  const SplitSystem system = buffers_->copies.split(whole);
  const IterationLimit limit = limit_of(system, settings, std::min(settings.point_iterations, kMaxPointIterations));
  if (limit.mixed && limit.by_mean && settings.substeps > 1) {
    const std::optional<Convergence> ended = buffers_->solve<float>(system, settings, of_collisions(limit), executor);
    if (ended) return *ended;
  }
  const bool twofold = settings.stopping.converges() || limit.mixed;
  return twofold ? *buffers_->solve<double>(system, settings, limit, executor)
                 : *buffers_->solve<float>(system, settings, limit, executor);
}

}  // namespace poise::solver
