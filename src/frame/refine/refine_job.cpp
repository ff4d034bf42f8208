// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "frame/refine/open_refinement.h"
#include "frame/refine/pair_cues.h"
#include "frame/refine/rank.h"
#include "parallel/cpu_clock.h"
#include "parallel/prefetch.h"

namespace poise::simulation {
namespace {

// Work between two looks at the clock where pieces are small: a look takes as long as an expansion. Chosen.
constexpr std::uint64_t kUnwatchedUnits = 128;
// A level of so few units is done whole, and at once after the one before. To come to rest there takes the pair its
// contact points, which take as long as half of the next level, and coming back to it a turn by its score; and a level
// that is not cut need keep nothing of the one before. Measured in `pile` with three quarters of the time that it wants
// (docs/performance.md).
constexpr std::uint64_t kSmallUnits = 64;
// Prefetched so many pairs ahead, before the poses that a pair names.
constexpr std::uint32_t kPairsAhead = 8;
// Where pairs go in order, one chunk of so many is looked at in each frame for how well it is seen. Chosen.
constexpr std::uint64_t kSeenEvery = 16;

std::uint64_t solved_of(double share, std::int64_t present) {
  return static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(std::max<std::int64_t>(present, 0))));
}

}  // namespace

// A job takes pairs, one after another, until it has done about a quantum of work. It brings each to its next level,
// and on to the one after that as long as no other pair has more to gain for the time it takes. Nobody sees any of it
// before the job commits.
class OpenRefinement::Job {
 public:
  Job(OpenRefinement& open, int worker)
      : open_(open),
        run_(*open.run),
        worker_(worker),
        batch_(open.batches[static_cast<std::size_t>(worker)]),
        tally_(run_.levels.tallies[static_cast<std::size_t>(worker)]) {
    now_ = run_.executor.time();
    if (tally_.begun != SteadyClock::time_point{}) return;
    tally_.begun = now_;
    tally_.cpu_before = parallel::thread_cpu_time();
  }

  bool run() {
    const bool more = fill_batch();
    if (unwatched_units_ > 0) look_at_clock();
    // Until here this has written what is this worker's own and nothing else.
    if (!run_.executor.commit(worker_)) return false;
    publish();
    tally_.ended = now_;
    if (!more) tally_.off_cpu = off_cpu();
    run_.levels.tallies[static_cast<std::size_t>(worker_)] = tally_;
    return more;
  }

 private:
  [[nodiscard]] bool in_order() const { return open_.chunks_in_order.has_value(); }

  // False: there is nothing more to take for this worker, or no time for it.
  bool fill_batch() {
    batch_.count = 0;
    batch_.notes.clear();
    do {
      if (in_order() && now_ >= open_.in_order_until) return false;
      const std::uint32_t item = in_order() ? next_in_order() : next_by_score();
      if (item == scheduler::PriorityBands::kNone) return false;
      Hand& hand = batch_.hands[batch_.count++];
      hand.item = item;
      const PairProgress& known = run_.levels.progress[item];
      hand.progress = known;
      // Not by what was found, which the caller may be writing (make_points_left).
      hand.due_before = known.points_due ? entries_of_points(known.level) : 0;
      hand.ended = Outcome::Completed;
      hand.completed = hand.again = hand.newly_ranked = hand.has_cues = false;
      if (!in_order() && !hand.progress.ranked && !rank(hand)) continue;
      // Not of the copy, which is still being written.
      if (!admits(known.level.next_units)) return stop();
      refine(hand);
      if (hand.ended == Outcome::Cut) return stop();
    } while (batch_.count < Batch::kMost && batch_units_ < run_.input.policy.quantum_units);
    return true;
  }
  bool stop() {
    cut_ = true;
    return false;
  }
  std::uint32_t next_by_score() {
    const TurnOrder& order = open_.turns;
    if (batch_.next >= batch_.past) take_block();
    if (batch_.next >= batch_.past) return run_.bands.take();
    if (run_.bands.highest() > order.turn_at(batch_.next)) {
      const std::uint32_t again = run_.bands.take();
      if (again != scheduler::PriorityBands::kNone) return again;
    }
    if (distant_) {
      if (batch_.next + kPosesAhead < batch_.past) {
        const ActivePair& ahead = run_.input.table.pairs[order.pair_at(batch_.next + kPosesAhead)];
        parallel::prefetch(*ahead.cached);
        prefetch_bodies(run_.input.scene, run_.input.motion, ahead);
      }
      if (batch_.next + kPairsAhead < batch_.past) prefetch_pair(order.pair_at(batch_.next + kPairsAhead));
    }
    return order.pair_at(batch_.next++);
  }
  void take_block() {
    const TurnOrder::Block block = open_.turns.take(run_.block, open_.batches.size());
    batch_.next = block.begin;
    batch_.past = block.end;
    if (!distant_) return;
    for (std::uint32_t place = block.begin; place < std::min(block.begin + kPairsAhead, block.end); ++place)
      prefetch_pair(open_.turns.pair_at(place));
  }
  HWY_INLINE void prefetch_pair(std::uint32_t item) {
    parallel::prefetch(run_.levels.progress[item]);
    parallel::prefetch(run_.input.table.pairs[item]);
  }
  // The best band of those that wait, as far as this worker can tell.
  [[nodiscard]] std::uint32_t best_turn() const {
    const std::uint32_t next = batch_.next < batch_.past ? open_.turns.turn_at(batch_.next) : open_.turns.next_turn();
    return std::max(next, run_.bands.highest());
  }
  std::uint32_t next_in_order() {
    const PairTable& table = run_.input.table;
    for (;;) {
      while (batch_.next < batch_.past) {
        if (batch_.next + kPairsAhead < batch_.past) parallel::prefetch(table.pairs[batch_.next + kPairsAhead]);
        const std::uint32_t ahead = batch_.next + kPosesAhead;
        if (ahead < batch_.past && run_.levels.progress[ahead].refinable())
          prefetch_bodies(run_.input.scene, run_.input.motion, table.pairs[ahead]);
        const PairProgress& pair = run_.levels.progress[batch_.next++];
        if (pair.refinable() && !pair.full) return batch_.next - 1;
      }
      const std::size_t chunk = open_.chunks_in_order->take(worker_);
      if (chunk == parallel::Shares::kNone) return scheduler::PriorityBands::kNone;
      if (table.known_of_chunk[chunk].refinable == 0) continue;
      batch_.next = static_cast<std::uint32_t>(table.begin_of(chunk));
      batch_.past = static_cast<std::uint32_t>(table.end_of(chunk));
      batch_.looks = (chunk + run_.input.frame) % kSeenEvery == 0;
    }
  }

  // May a piece of the next `units` begin? If so it counts as begun.
  [[nodiscard]] bool admits(std::uint64_t units) {
    const std::uint64_t piece = std::min<std::uint64_t>(units, run_.input.policy.quantum_units);
    const bool admitted = run_.budget.admits(now_ + time_of_points_due(), unwatched_units_ + piece,
                                             solved_of(run_.solved_share, open_.contacts.get()));
    if (admitted) {
      unwatched_units_ += piece;
      batch_units_ += piece;
    }
    return admitted;
  }
  // How long it takes to make the contact points of the pairs as they are.
  [[nodiscard]] Nanoseconds time_of_points_due() const { return time_of_points(run_.entry_cost_ns, open_.due.get()); }
  // Since this worker's first job.
  [[nodiscard]] Nanoseconds off_cpu() const {
    return std::max(Nanoseconds(0), now_ - tally_.begun - (parallel::thread_cpu_time() - tally_.cpu_before));
  }
  void look_at_clock() {
    const SteadyClock::time_point begun = now_;
    now_ = run_.executor.time();
    const Nanoseconds took = now_ - begun;
    tally_.busy += took;
    tally_.begun_units += unwatched_units_;
    const Nanoseconds excess = took - run_.budget.job_cost(unwatched_units_);
    const bool exceeds = excess > tally_.overrun + tally_.overrun_off_cpu;
    if (exceeds || took > tally_.longest) note_long(begun, took, excess, exceeds);
    unwatched_units_ = 0;
  }
  // A piece that took longer than any before it, or exceeded its forecast by more.
  void note_long(SteadyClock::time_point begun, Nanoseconds took, Nanoseconds excess, bool exceeds) {
    // A shorter excess makes no frame late, and is not worth the clock's time. Chosen.
    constexpr Nanoseconds kLookedInto{50'000};
    Nanoseconds taken{0};  // by the system
    if (excess >= kLookedInto) {
      const Nanoseconds before = tally_.off_cpu;
      tally_.off_cpu = off_cpu();
      taken = std::clamp(tally_.off_cpu - before, Nanoseconds(0), excess);
      tally_.busy -= taken;
    }
    if (exceeds) {
      tally_.overrun_off_cpu = taken;
      tally_.overrun = excess - taken;
    }
    if (took - taken <= tally_.longest) return;
    tally_.longest = took - taken;
    tally_.longest_pair = batch_.hands[batch_.count - 1].item;
    tally_.longest_units = static_cast<std::uint32_t>(unwatched_units_);
    tally_.longest_begun = begun;
    tally_.longest_ended = now_;
  }

  // Of a pair that waited where it was ranked in an earlier frame. False: it has its turn later, or none.
  bool rank(Hand& hand) {
    hand.newly_ranked = hand.has_cues = true;
    const RankedPair ranked = ranked_pair(run_.input, *open_.cues, run_.facts, hand.item, hand.progress,
                                          run_.levels.found.of(hand.progress).contact, hand.cues);
    hand.band = ranked.band;
    const bool now = hand.band >= best_turn();
    hand.again = !ranked.left_out && !now;
    return !ranked.left_out && now;
  }
  [[nodiscard]] const scheduler::PairCues& cues_of(Hand& hand) const {
    if (hand.has_cues) return hand.cues;
    if (run_.cues_kept) return run_.levels.cues[hand.item];
    open_.cues->fill(hand.item, hand.cues);
    hand.has_cues = true;
    return hand.cues;
  }

  // Levels of the pair, in this worker's own memory.
  void refine(Hand& hand) {
    const RefineInput& input = run_.input;
    if (hand.progress.level.level > 0) run_.levels.found.read(hand.progress, hand.found);
    if (in_order() && batch_.looks) {
      scheduler::PairCues looked;
      open_.cues->fill(hand.item, looked);
      hand.progress.seen = seen_band(input.policy, looked);
    }
    const PosedPair placed = posed(input.motion, input.table.pairs[hand.item]);
    collision::PairFrame frame = frame_of(input.refiner(), placed);
    collision::FrontPool& pool = run_.pools[static_cast<std::size_t>(worker_)];
    const collision::FrontPool::Mark mark = pool.mark();
    do {
      next_level(hand, placed, frame);
    } while (hand.ended == Outcome::Completed && hand.progress.refinable() && goes_on(hand));
    if (hand.found.gaps_only) {
      hand.passed.complete(input.refiner(), run_.pools, placed, frame, hand.progress.level, hand.found, worker_);
    }
    if (!hand.progress.refinable() && input.terms.contact != ContactModel::Paper) pool.release(mark);
  }
  void next_level(Hand& hand, const PosedPair& placed, collision::PairFrame& frame) {
    const collision::PairLevel before = hand.progress.level;
    const bool whole = before.next_units <= kSmallUnits && !before.next_is_polygons();
    if (!whole) batch_.before = hand.found;
    // The level after it is so small that it has its turn at once: of one entry always, and in order whatever comes.
    const bool passes = whole && before.passes_next() && (in_order() || (perceptual_ && before.level == 0));
    const PassedLevel passed(before, hand.found, run_.pools[static_cast<std::size_t>(worker_)]);
    hand.ended = complete_level(run_.input.refiner(), run_.pools, placed, frame, hand.progress.level, hand.found,
                                worker_, passes ? Followed::AtOnce : Followed::No, [&](std::uint64_t next_units) {
                                  if (whole) return true;
                                  look_at_clock();
                                  return admits(next_units);
                                });
    if (unwatched_units_ >= kUnwatchedUnits || run_.log != nullptr) look_at_clock();
    note_outcome(hand.progress.level.apart, before.next_units, hand.ended, tally_);
    if (run_.log != nullptr) batch_.notes.push_back({hand.item, kind_of(hand.ended), now_});
    if (hand.ended == Outcome::Completed) {
      hand.completed = true;
      if (hand.found.gaps_only) hand.passed = passed;
      return;
    }
    hand.progress.level = before;
    if (hand.ended == Outcome::Cut) hand.progress.stop_for_time();
    if (!whole) hand.found = batch_.before;
  }
  // To the next level of the same pair at once?
  [[nodiscard]] bool goes_on(Hand& hand) {
    if (!in_order() && !has_turn(hand)) return false;
    if (!admits(hand.progress.level.next_units)) return false;
    hand.again = false;
    return true;
  }
  // Where the pair has its turn by its score, and whether that is now.
  [[nodiscard]] bool has_turn(Hand& hand) {
    const RefineInput& input = run_.input;
    const collision::PairLevel& level = hand.progress.level;
    hand.again = true;
    const bool small = perceptual_ && level.next_units <= kSmallUnits && !level.next_is_polygons();
    // A front that waits takes memory; one whose pair comes to its end gives it back.
    if (small || run_.pools[static_cast<std::size_t>(worker_)].scarce()) {
      hand.band = best_turn();
      return true;
    }
    const double score = score_of(input, run_.facts, cues_of(hand), hand.progress, hand.found.contact, hand.item);
    hand.again = !scheduler::left_out(input.policy, score);
    hand.band = scheduler::band_of(input.policy, score);
    hand.progress.turn = turn_at(hand.band);
    if (!hand.again) hand.progress.stop = Stop::Unseen;
    return hand.again && hand.band >= best_turn();
  }

  void publish() {
    std::int64_t more_contacts = 0;
    std::int64_t more_ended = 0;
    std::int64_t more_due = 0;
    for (const Hand& hand : std::span(batch_.hands).first(batch_.count)) {
      PairProgress& pair = run_.levels.progress[hand.item];
      pair.seen = hand.progress.seen;
      pair.band = hand.progress.band;
      pair.turn = hand.progress.turn;
      pair.stop = hand.progress.stop;
      if (hand.newly_ranked) {
        pair.ranked = true;
        if (run_.cues_kept) run_.levels.cues[hand.item] = hand.cues;
      }
      if (hand.completed) {
        const bool was_apart = pair.apart();
        pair.level = hand.progress.level;
        run_.levels.found.keep(pair, hand.found, run_.input.table.pairs[hand.item].reach_m, worker_);
        if (pair.apart() != was_apart && !pair.held) more_contacts += was_apart ? 1 : -1;
        const bool was_due = pair.points_due;
        pair.points_due = points_due(pair, hand.found);
        if (pair.points_due && !was_due) batch_.due.push_back(hand.item);
        more_due += std::int64_t{pair.points_due ? entries_of_points(pair.level) : 0U} - hand.due_before;
      }
      if (hand.ended == Outcome::Full) pair.full = true;
      if (!pair.refinable() || pair.full) ++more_ended;
      if (hand.again) run_.bands.put(hand.item, hand.band);
    }
    if (more_contacts != 0) open_.contacts.add(more_contacts);
    if (more_ended != 0) open_.ended.add(more_ended);
    if (more_due != 0) open_.due.add(more_due);
    if (cut_) open_.cut.set(1);
    for (const RefinementNote& note : batch_.notes) run_.log->note(worker_, note.item, note.kind, note.when);
  }

  OpenRefinement& open_;
  Run& run_;
  const int worker_;
  Batch& batch_;
  WorkerTally tally_;
  SteadyClock::time_point now_;
  std::uint64_t unwatched_units_ = 0;  // since now_
  std::uint64_t batch_units_ = 0;
  bool cut_ = false;
  const bool distant_ = run_.input.table.size() > parallel::kPairsAtHand;
  const bool perceptual_ = run_.input.policy.kind == scheduler::PolicyKind::Perceptual &&
                           run_.input.policy.seen_threshold_rad == 0;  // other policies compare pairs at each level
};

bool OpenRefinement::operator()(int worker) { return Job(*this, worker).run(); }

}  // namespace poise::simulation
