// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "frame/budget/cpu_clock.h"
#include "frame/budget/frame_time.h"
#include "frame/refine/open_refinement.h"
#include "frame/refine/rank.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

std::uint64_t solved_of(double share, std::int64_t present) {
  return static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(std::max<std::int64_t>(present, 0))));
}

// The larger of two excesses, each with what the system took from it.
void note_overrun(Nanoseconds own, Nanoseconds off_cpu, FrameReport& report) {
  if (own + off_cpu <= report.longest_overrun + report.overrun_off_cpu) return;
  report.longest_overrun = own;
  report.overrun_off_cpu = off_cpu;
}

}  // namespace

void refine_until_cut(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                      CompletedLevels& levels, FrameReport& report, parallel::Executor& executor) {
  // A job that is under way at the cut may take twice its forecast before it is abandoned. Chosen.
  constexpr Nanoseconds kLeastPatience{100'000};
  const SteadyClock::time_point start = input.begun;
  Forecasts& forecasts = resources.forecasts;
  levels.waits = {};
  const FramePlan plan = plan_frame(input, start, forecasts, levels, report, executor);
  OpenRefinement& open = resources.open;
  open.run.emplace(OpenRefinement::Run{input, resources.pools, resources.bands, levels, executor, facts, plan.budget,
                                       forecasts.solved_share, resources.log});
  open.hands.resize(levels.tallies.size());
  open.contacts.set(plan.present);
  levels.present = plan.present;
  open.cut.set(0);
  const scheduler::FrameBudget& budget = open.run->budget;
  const SteadyClock::time_point first_cut = budget.cut(plan.expected);
  const SteadyClock::time_point planned = SteadyClock::now();
  report.planning = planned - start;
  if (first_cut <= planned || !rank_pairs(input, resources, facts, planned, first_cut, levels, report, executor))
    return;
  const Nanoseconds patience = std::max(kLeastPatience, 2 * budget.job_cost(input.policy.quantum_units));
  const parallel::Waits waits_before = executor.waits();
  const Nanoseconds cpu_before = thread_cpu_time();
  const SteadyClock::time_point run_begun = SteadyClock::now();
  // A run ends when this thread finds nothing to take; what the others had in hand then may have left another level to
  // do.
  do {
    report.jobs_abandoned += executor.run_with({first_cut, patience}, open);
  } while (report.jobs_abandoned == 0 && open.cut.get() == 0 && !resources.bands.empty());
  report.jobs_discarded += report.jobs_abandoned;
  const SteadyClock::time_point end = SteadyClock::now();
  levels.waits = executor.waits() - waits_before;
  levels.present = open.contacts.get();
  const std::uint64_t left = expected_solved(forecasts, levels.present);
  report.reserve_at_cut = budget.reserve(left);
  report.tail_forecast = budget.tail_forecast(left);
  report.tail_work.contacts = left;
  const SteadyClock::time_point last_cut = std::max(first_cut, budget.cut(left));
  report.refine_available = last_cut - start;
  // While this thread waited for another one's job, the machine may have held that one up.
  const WorkerTally& own = levels.tallies[0];
  report.waited = own.ended == SteadyClock::time_point{} ? Nanoseconds(0) : end - own.ended;
  Nanoseconds held_up{0};
  for (std::size_t w = 1; w < levels.tallies.size(); ++w) held_up = std::max(held_up, levels.tallies[w].off_cpu);
  if (report.jobs_abandoned > 0) held_up = report.waited;
  report.off_cpu = std::min(report.waited, held_up);
  const Nanoseconds own_off_cpu = end - run_begun - (thread_cpu_time() - cpu_before) - report.waited;
  const Nanoseconds past_cut = std::max(Nanoseconds(0), end - last_cut);
  const Nanoseconds taken = std::min(past_cut, std::max(Nanoseconds(0), own_off_cpu) + report.off_cpu);
  note_overrun(past_cut - taken, taken, report);
  for (const WorkerTally& tally : levels.tallies) note_overrun(tally.overrun, tally.overrun_off_cpu, report);
}

// A job brings one pair to its next level, and goes on with the one after that as long as no other pair has more to
// gain for the time it takes.
class OpenRefinement::Job {
 public:
  Job(OpenRefinement& open, int worker)
      : open_(open), run_(*open.run), worker_(worker), tally_(run_.levels.tallies[static_cast<std::size_t>(worker)]) {
    now_ = SteadyClock::now();
    if (tally_.begun != SteadyClock::time_point{}) return;
    tally_.begun = now_;
    tally_.cpu_before = thread_cpu_time();
  }

  bool run() {
    item_ = run_.bands.take();
    const bool there = item_ != scheduler::PriorityBands::kNone;
    if (!there || !admits(run_.levels.progress[item_].level.next_units)) {
      if (!run_.executor.commit(worker_)) return false;
      if (there) open_.cut.set(1);
      return end(false);
    }
    refine();
    // Until here this has written what is this worker's own and nothing else.
    return run_.executor.commit(worker_) && publish();
  }

 private:
  [[nodiscard]] std::uint64_t piece_of(std::uint64_t units) const {
    return std::min<std::uint64_t>(units, run_.input.policy.quantum_units);
  }
  [[nodiscard]] bool admits(std::uint64_t units) {
    piece_units_ = piece_of(units);
    return run_.budget.admits(now_, piece_units_, solved_of(run_.solved_share, open_.contacts.get()));
  }
  bool end(bool more) {
    tally_.ended = now_;
    if (!more) tally_.off_cpu = off_cpu();
    run_.levels.tallies[static_cast<std::size_t>(worker_)] = tally_;
    return more;
  }
  // Since this worker's first job.
  [[nodiscard]] Nanoseconds off_cpu() const {
    return std::max(Nanoseconds(0), now_ - tally_.begun - (thread_cpu_time() - tally_.cpu_before));
  }
  void note_piece(SteadyClock::time_point begun) {
    now_ = SteadyClock::now();
    const Nanoseconds took = now_ - begun;
    tally_.busy += took;
    if (took > tally_.longest) {
      tally_.longest = took;
      tally_.longest_pair = item_;
      tally_.longest_units = static_cast<std::uint32_t>(piece_units_);
      tally_.longest_begun = begun;
    }
    const Nanoseconds excess = took - run_.budget.job_cost(piece_units_);
    if (excess > tally_.overrun + tally_.overrun_off_cpu) note_excess(excess);
  }
  void note_excess(Nanoseconds excess) {
    // A shorter one makes no frame late, and is not worth the clock's time. Chosen.
    constexpr Nanoseconds kLookedInto{50'000};
    tally_.overrun_off_cpu = Nanoseconds(0);
    if (excess >= kLookedInto) {
      const Nanoseconds before = tally_.off_cpu;
      tally_.off_cpu = off_cpu();
      tally_.overrun_off_cpu = std::clamp(tally_.off_cpu - before, Nanoseconds(0), excess);
    }
    tally_.overrun = excess - tally_.overrun_off_cpu;
  }

  // Levels of the pair, in this worker's own memory.
  void refine() {
    const RefineInput& input = run_.input;
    Hand& hand = open_.hands[static_cast<std::size_t>(worker_)];
    const PosedPair placed = posed(input.motion, input.table.pairs[item_]);
    hand.progress = run_.levels.progress[item_];
    if (hand.progress.level.level > 0) hand.found = run_.levels.found[item_];
    collision::PairFrame frame = frame_of(input.refiner(), placed);
    for (;;) {
      // A level that is cut leaves the one before it as it was.
      hand.level = hand.progress.level;
      hand.next = hand.found;
      const std::uint64_t units = hand.level.next_units;
      SteadyClock::time_point piece_begun = now_;
      ended_ = complete_level(input.refiner(), run_.pools, placed, frame, hand.level, hand.next, worker_,
                              [&](std::uint64_t next_units) {
                                note_piece(piece_begun);
                                piece_begun = now_;
                                return admits(next_units);
                              });
      note_piece(piece_begun);
      note_outcome(hand.level.apart, units, ended_, tally_);
      if (ended_ != Outcome::Completed) return;
      completed_at_[completed_++] = now_;
      hand.progress.level = hand.level;
      std::swap(hand.found, hand.next);
      if (!hand.progress.refinable() || !goes_on(hand.progress)) return;
    }
  }
  [[nodiscard]] bool goes_on(const PairProgress& progress) {
    const RefineInput& input = run_.input;
    const std::uint32_t band =
        scheduler::band_of(input.policy, score_of(input, run_.facts, run_.levels.cues[item_], progress, item_));
    return band >= run_.bands.highest() && admits(progress.level.next_units);
  }

  bool publish() {
    const RefineInput& input = run_.input;
    const Hand& hand = open_.hands[static_cast<std::size_t>(worker_)];
    PairProgress& pair = run_.levels.progress[item_];
    if (completed_ > 0) {
      const bool was_apart = pair.apart();
      pair.level = hand.progress.level;
      run_.levels.found[item_] = hand.found;
      if (pair.apart() != was_apart && !pair.held) open_.contacts.add(was_apart ? 1 : -1);
    }
    if (run_.log != nullptr) {
      for (std::size_t k = 0; k < completed_; ++k)
        run_.log->note(worker_, item_, RefinementStep::Kind::Completed, completed_at_[k]);
      if (ended_ != Outcome::Completed) run_.log->note(worker_, item_, kind_of(ended_), now_);
    }
    if (ended_ == Outcome::Full) pair.full = true;
    if (ended_ == Outcome::Cut) open_.cut.set(1);
    if (ended_ == Outcome::Completed && pair.refinable())
      run_.bands.put(
          item_, scheduler::band_of(input.policy, score_of(input, run_.facts, run_.levels.cues[item_], pair, item_)));
    return end(ended_ != Outcome::Cut);
  }

  OpenRefinement& open_;
  Run& run_;
  const int worker_;
  WorkerTally tally_;
  SteadyClock::time_point now_;
  std::uint32_t item_ = scheduler::PriorityBands::kNone;
  std::uint64_t piece_units_ = 0;
  Outcome ended_ = Outcome::Completed;  // of the last level
  std::size_t completed_ = 0;
  std::array<SteadyClock::time_point, kPolygonBin + 1> completed_at_;
};

bool OpenRefinement::operator()(int worker) { return Job(*this, worker).run(); }

}  // namespace poise::simulation
