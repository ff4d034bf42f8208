// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>
#include <utility>

#include "parallel/prefetch.h"
#include "parallel/shared_counters.h"
#include "solver/impacts/impact_iteration.h"
#include "solver/impacts/impact_lanes.h"
#include "solver/solver.h"

namespace poise::solver {
namespace {

// True if the start of this step is nearer to the time of impact than that of the next one, as of rows in lanes.
bool meets_now(double gap_m, double closing_mps, double dt_s) { return gap_m <= 0.5 * closing_mps * dt_s; }

// Applies an impulse along a wrench between the bodies of a row that is new: what removes the approach speed, times one
// and the restitution.
bool answer_single(const System& system, ContactRow& row, double closing_mps, double restitution, Wrench& single) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  Turns turns;
  if (!prepare_wrench(a.inverse_mass, system.inverse_inertia[row.a], b.inverse_mass, system.inverse_inertia[row.b],
                      single, turns))
    return false;
  const double lambda_ns = (1.0 + restitution) * closing_mps * single.effective_mass;
  apply_impulse(single, turns, lambda_ns, a, b);
  row.point_impulse_ns += lambda_ns * single.direction;
  return true;
}

// DO eq. 1-3, contact by contact in canonical order, each with the approach speed taken anew.
bool answer_points(const System& system, ContactRow& row, double dt_s, double still_mps) {
  const SolverBody& a = system.bodies[row.a];
  const SolverBody& b = system.bodies[row.b];
  bool solved = false;
  for (std::uint32_t p = row.points_begin; p < row.points_end; ++p) {
    const PointContact& point = system.points[p];
    const Vec3& n = point.normal;
    const Vec3 velocity =
        a.velocity_mps + a.spin_radps.cross(point.arm_a_m) - b.velocity_mps - b.spin_radps.cross(point.arm_b_m);
    const double closing = n.dot(velocity);
    if (closing <= still_mps || !meets_now(point.gap_m, closing, dt_s)) continue;
    Wrench single{n, point.arm_a_m.cross(n), point.arm_b_m.cross(n)};
    const double e = row.restitution * closing > still_mps ? row.restitution : 0.0;
    solved = answer_single(system, row, closing, e, single) || solved;
  }
  return solved;
}

// Solves contact points of the pair that certainly penetrate and would rebound: resting contact has no restitution.
bool answer_overlaps(const System& system, std::size_t i, double still_mps) {
  ContactRow& row = system.rows[i];
  bool solved = false;
  const RowActivation& gate = system.scratch.activations[i];
  for (const OverlapPoint& point : system.overlaps.subspan(gate.overlaps_begin, gate.overlap_count)) {
    Wrench single{point.normal, point.moment_a_m, point.moment_b_m};
    const double closing = approach_mps(single, system.bodies[row.a], system.bodies[row.b]);
    if (row.restitution * closing <= still_mps) continue;
    solved = answer_single(system, row, closing, row.restitution, single) || solved;
  }
  return solved;
}

template <class Use>
void for_each_bit(std::uint64_t bits, Use&& use) {
  for (; bits != 0; bits &= bits - 1U) use(static_cast<std::size_t>(std::countr_zero(bits)));
}

// Bodies of rows lie anywhere in memory: what is known of them is prefetched some rows ahead.
constexpr std::size_t kChangesAhead = 8;

// The rounds of impacts over the rows of a step.
class Rounds {
 public:
  Rounds(const System& system, const SolveSettings& settings)
      : system_(system),
        dt_s_(settings.dt_s),
        converges_(settings.stopping.converges()),
        lanes_{system.rows.data(), system.overlaps.data(), system.bodies.data(), system.inverse_inertia.data(), dt_s_,
               still_mps(settings)},
        changed_(system.scratch.changed),
        activations_(system.scratch.activations),
        distant_(system.rows.size() > parallel::kPairsAtHand),
        steps_(system.coloring.own_colors() + 1) {
    changed_.assign(system.bodies.size(), 0);
  }

  // Looks at all rows that may need an impulse; true if one did.
  bool go(std::uint32_t round, parallel::Executor& executor) {
    if (converges_) system_.scratch.change_ns.assign(system_.rows.size(), 0.0);
    parallel::Shared<int> solved(0);
    for_each_run(system_, ImpactBatch::kRows, executor, [&](std::uint32_t step, std::size_t begin, std::size_t end) {
      const Turn turn{round == 1, round * steps_ + step};
      if (answer(turn, begin, end) && solved.get() == 0) solved.set(1);
    });
    return answer_shared({round == 1, round * steps_ + steps_ - 1}, executor) || solved.get() != 0;
  }

  // After the last round. A pair that closes fast enough to rebound keeps its speed until it meets, in this step or the
  // next. Each look has noted it; rows that impulses changed since are looked at again.
  void note_rebounds(std::uint32_t last_round, parallel::Executor& executor) {
    const auto note = [&](std::uint32_t step, std::size_t begin, std::size_t end) {
      const Turn turn{false, (last_round + 1) * steps_ + step};
      ImpactBatch batch;
      for (std::size_t i = begin; i < end; ++i) {
        const RowActivation& gate = activations_[i];
        if (gate.ready && (gate.kind != RowKind::Wrench || !skips(turn, gate))) add(i, batch);
      }
      look(batch);
    };
    for_each_run(system_, ImpactBatch::kRows, executor, note);
    for_shared_rows(executor, [&](std::size_t begin, std::size_t end) { note(steps_ - 1, begin, end); });
  }

 private:
  // When a colour has its turn in a round.
  struct Turn {
    bool first = true;      // round
    std::uint32_t now = 0;  // counts the turns of all rounds
  };

  // Some of the rows of a run.
  struct RowList {
    std::uint32_t row[ImpactBatch::kRows + 1];
    std::size_t count = 0;
    void add(std::size_t i) { row[count++] = static_cast<std::uint32_t>(i); }
    // Without a branch: no processor foresees which.
    void add_if(bool wanted, std::size_t i) {
      row[count] = static_cast<std::uint32_t>(i);
      count += wanted ? 1U : 0U;
    }
    [[nodiscard]] std::span<const std::uint32_t> all() const { return std::span(row).first(count); }
  };

  // No impulse has changed the velocities of its bodies since it was last looked at, or in the first round, at all and
  // they are not fast.
  [[nodiscard]] bool skips(const Turn& turn, const RowActivation& gate) const {
    const std::uint32_t last = std::max(changed_[gate.a], changed_[gate.b]);
    return turn.first ? !gate.fast && last == 0 : last + steps_ < turn.now;
  }

  // What skips() reads of a row. Other workers have written it since the last round.
  HWY_INLINE void prefetch_changes(const RowActivation& gate) const {
    hwy::Prefetch(&changed_[gate.a]);
    hwy::Prefetch(&changed_[gate.b]);
  }

  void add(std::size_t i, ImpactBatch& batch) const {
    const RowActivation& gate = activations_[i];
    batch.add(static_cast<std::uint32_t>(i), gate.a, gate.b);
    if (!distant_) return;
    prefetch_lines(&system_.rows[i], 2);
    hwy::Prefetch(&system_.bodies[gate.a]);
    hwy::Prefetch(&system_.bodies[gate.b]);
  }

  HWY_INLINE static void prefetch_lines(const void* from, std::size_t lines) {
    constexpr std::size_t kLine = 64;
    for (std::size_t line = 0; line < lines; ++line) hwy::Prefetch(static_cast<const std::byte*>(from) + line * kLine);
  }

  void look(ImpactBatch& batch) {
    look_at_rows(lanes_, batch);
    for (std::size_t k = 0; k < batch.count; ++k) activations_[batch.row[k]].bounces = (batch.rebounds >> k & 1U) != 0;
  }

  void note_change(const Turn& turn, std::uint32_t a, std::uint32_t b) {
    if (system_.bodies[a].inverse_mass > 0) changed_[a] = turn.now;
    if (system_.bodies[b].inverse_mass > 0) changed_[b] = turn.now;
  }

  // Rows that are to be looked at, filled if they were not yet, by what they answer by.
  struct Awake {
    ImpactBatch by_wrench;
    RowList by_points, overlapping;
  };
  void wake(const Turn& turn, std::size_t begin, std::size_t end, Awake& into) {
    RowList awake;
    for (std::size_t i = begin; i < end; ++i) {
      if (distant_ && i + kChangesAhead < activations_.size()) prefetch_changes(activations_[i + kChangesAhead]);
      awake.add_if(!skips(turn, activations_[i]), i);
    }
    for (const std::uint32_t i : awake.all()) {
      RowActivation& gate = activations_[i];
      if (!gate.ready) {
        system_.source->fill(i);
        activate(system_.rows[i], gate);
      }
      if (gate.kind == RowKind::Degenerate) continue;
      if (gate.kind == RowKind::Wrench) {
        add(i, into.by_wrench);
      } else {
        if (turn.first) into.by_points.add(i);
        if (gate.overlap_count > 0) into.overlapping.add(i);
      }
    }
    look(into.by_wrench);
  }

  template <class Visit>
  void for_shared_rows(parallel::Executor& executor, Visit&& visit) {
    const std::size_t first = system_.coloring.shared_begin();
    parallel::parallel_for(executor, system_.rows.size() - first, ImpactBatch::kRows,
                           [&](std::size_t begin, std::size_t end, int) { visit(first + begin, first + end); });
  }

  // Rows without a colour of their own; true if one needed an impulse. All are looked at as their bodies stand; then
  // those that need an impulse are answered one after another, each as the ones before it left its bodies.
  bool answer_shared(const Turn& turn, parallel::Executor& executor) {
    const std::size_t first = system_.coloring.shared_begin();
    if (first == system_.rows.size()) return false;
    std::vector<std::uint8_t>& needed = system_.scratch.needed;
    needed.assign(system_.rows.size() - first, 0);
    for_shared_rows(executor, [&](std::size_t begin, std::size_t end) {
      Awake awake;
      wake(turn, begin, end, awake);
      const ImpactBatch& batch = awake.by_wrench;
      for_each_bit(batch.needs | batch.overlaps_rebound, [&](std::size_t k) { needed[batch.row[k] - first] = 1; });
      for (const std::uint32_t i : awake.by_points.all()) needed[i - first] = 1;
      for (const std::uint32_t i : awake.overlapping.all()) needed[i - first] = 1;
    });
    bool solved = false;
    for (std::size_t k = 0; k < needed.size(); ++k) {
      if (needed[k] != 0 && answer(turn, first + k, first + k + 1)) solved = true;
    }
    return solved;
  }

  // Rows of one colour; true if one needed an impulse.
  bool answer(const Turn& turn, std::size_t begin, std::size_t end) {
    Awake awake;
    wake(turn, begin, end, awake);
    ImpactBatch& batch = awake.by_wrench;
    RowList& overlapping = awake.overlapping;
    bool solved = give(turn, batch);
    for_each_bit(batch.needs | batch.overlaps_rebound, [&](std::size_t k) {
      const RowActivation& gate = activations_[batch.row[k]];
      if (gate.overlap_count == 0) return;
      overlapping.add(batch.row[k]);
      if (distant_) prefetch_lines(&system_.overlaps[gate.overlaps_begin], 3);
    });
    for (const std::uint32_t i : awake.by_points.all()) {
      if (!answer_points(system_, system_.rows[i], dt_s_, lanes_.still_mps)) continue;
      note_change(turn, system_.rows[i].a, system_.rows[i].b);
      solved = true;
    }
    return answer_overlapping(turn, overlapping.all()) || solved;
  }

  // Contact points that certainly penetrate. Few close so fast that they rebound: first all are looked at.
  bool answer_overlapping(const Turn& turn, std::span<const std::uint32_t> rows) {
    bool solved = false;
    for (std::size_t next = 0; next < rows.size();) {
      ImpactBatch batch;
      std::uint32_t row_of[ImpactBatch::kRows];
      for (; next < rows.size() && batch.count + kOverlapsOfRow <= ImpactBatch::kRows; ++next) {
        const RowActivation& gate = activations_[rows[next]];
        for (std::uint32_t p = gate.overlaps_begin; p < gate.overlaps_begin + gate.overlap_count; ++p) {
          row_of[batch.count] = rows[next];
          batch.add(p, gate.a, gate.b);
        }
      }
      look_at_overlaps(lanes_, batch);
      std::size_t done = system_.rows.size();
      for_each_bit(batch.rebounds, [&](std::size_t k) {
        const std::size_t i = row_of[k];
        if (std::exchange(done, i) == i || !answer_overlaps(system_, i, lanes_.still_mps)) return;
        note_change(turn, activations_[i].a, activations_[i].b);
        solved = true;
      });
    }
    return solved;
  }

  // The impulses that rows need along their wrenches.
  bool give(const Turn& turn, const ImpactBatch& batch) {
    ImpactBatch needed;
    for_each_bit(batch.needs, [&](std::size_t k) {
      needed.lambda_ns[needed.count] = batch.lambda_ns[k];
      needed.add(batch.row[k], batch.a[k], batch.b[k]);
    });
    give_impulses(lanes_, needed);
    for (std::size_t k = 0; k < needed.count; ++k) {
      double& total_ns = system_.rows[needed.row[k]].total_ns;
      const double before_ns = std::exchange(total_ns, total_ns + needed.lambda_ns[k]);
      if (converges_) system_.scratch.change_ns[needed.row[k]] = total_ns - before_ns;
      note_change(turn, needed.a[k], needed.b[k]);
    }
    return needed.count > 0;
  }

  const System& system_;
  double dt_s_;
  bool converges_;
  ImpactLanes lanes_;
  std::vector<std::uint32_t>& changed_;
  std::vector<RowActivation>& activations_;
  bool distant_;  // rows lie beyond the cache of a core
  std::uint32_t steps_;
};

}  // namespace

Convergence solve_impacts(const System& system, const SolveSettings& settings, parallel::Executor& executor) {
  const Stopping& stopping = settings.stopping;
  const std::uint32_t rounds = system.rows.size() <= kFewRows ? kImpactIterationsOfFew : kImpactIterations;
  const std::uint32_t most = stopping.converges() ? stopping.max_iterations : rounds;
  Convergence ended{!stopping.converges(), 0};
  std::vector<RowActivation>& activations = system.scratch.activations;
  if (system.source == nullptr) {
    activations.resize(system.rows.size());
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      const ContactRow& row = system.rows[i];
      activations[i] = {row.a, row.b, activations[i].overlaps_begin, activations[i].overlap_count};
      activate(row, activations[i]);
    }
  } else if (std::none_of(activations.begin(), activations.end(),
                          [](const RowActivation& gate) { return gate.fast; })) {
    ended.reached = true;
    return ended;
  }
  Rounds solver(system, settings);
  for (std::uint32_t round = 1; round <= most; ++round) {
    ++ended.iterations;
    const bool solved = solver.go(round, executor);
    if (!solved || (stopping.converges() && settled(system, stopping, &ContactRow::total_ns))) {
      ended.reached = true;
      break;
    }
  }
  solver.note_rebounds(ended.iterations, executor);
  return ended;
}

}  // namespace poise::solver
