// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "frame/budget/cpu_clock.h"
#include "frame/stages.h"
#include "verify/pair_probe.h"

namespace poise::simulation {
namespace {

constexpr std::uint32_t kRoom = 1U << 22U;
// Pairs whose impulses are timed: the paper's model reads their fronts, which must have room beside each other.
constexpr std::size_t kSolved = 50;
constexpr int kAnswers = 10;

void find(WorldState& world, ProbeLevel level, double dt_s) {
  const StepInput input = step_to(level, dt_s);
  FrameReport report;
  predict(world, input);
  find_pairs(world, input, report);
  world.buffers.pools[0].clear();
}

// One after another; fronts that nobody reads any more give their room back.
bool refine_all(WorldState& world, bool keep_fronts) {
  bool room = true;
  for (std::size_t i = 0; i < world.buffers.pairs.size(); ++i) {
    if (!keep_fronts) world.buffers.pools[0].clear();
    room = refine_pair(world, world.buffers.pairs[i], world.buffers.found[i], 0) && room;
  }
  return room;
}

// The overlap tests alone: fronts in two buffers that are used again for every pair.
class OverlapTests {
 public:
  OverlapTests() {
    for (std::vector<collision::FrontEntry>& front : fronts_) front.resize(kRoomOfPair);
  }
  void run(const WorldState& world, Level max_level) {
    for (const ActivePair& pair : world.buffers.pairs) {
      const Level deepest =
          collision::deepest_level(*world.bodies.shape[pair.a], *world.bodies.shape[pair.b], max_level);
      fronts_[0][0] = {0, 0};
      std::size_t count = 1;
      for (std::size_t k = 0; k < deepest && count > 0; ++k) {
        const std::span<const collision::FrontEntry> front(fronts_[k % 2].data(), count);
        count = collision::expand(frame_of(world, pair), front, fronts_[1 - k % 2]).hits;
      }
    }
  }

 private:
  static constexpr std::size_t kRoomOfPair = 1U << 19U;
  std::array<std::vector<collision::FrontEntry>, 2> fronts_;
};

// Rows and impulses of all pairs; every wrench meets, whatever its gap.
void answer_all(WorldState& world, double dt_s) {
  FrameReport report;
  list_contact_pairs(world, dt_s, 0, report);
  fill_rows(world);
  for (solver::ContactRow& row : world.buffers.rows) row.gap_m = -std::numeric_limits<double>::max();
  solver::solve_impacts(impact_system(world), {dt_s, Vec3::Zero(), 1, {}}, *world.executor);
}

template <class Work>
double nanoseconds(Work&& work) {
  const Nanoseconds before = thread_cpu_time();
  work();
  return static_cast<double>((thread_cpu_time() - before).count());
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Readings {
  std::vector<double> refine_ns, overlap_ns, response_ns;
};

}  // namespace

Result<std::vector<PairCost>> PairProbe::costs(const PairSettings& settings, std::span<const PairState> states,
                                               std::span<const ProbeLevel> levels, double dt_s, int rounds) {
  if (states.empty() || rounds < 1) return bad_input("states, rounds: must not be empty");
  Result<World> many = world_of(settings, states, kRoom);
  Result<World> few = world_of(settings, states.first(std::min(kSolved, states.size())), kRoom);
  if (!many || !few) return many ? few.error() : many.error();
  WorldState& refined = *many.value().state_;
  WorldState& solved = *few.value().state_;
  const auto pairs_of = [](const WorldState& world) {
    return static_cast<double>(std::max<std::size_t>(world.buffers.pairs.size(), 1));
  };
  OverlapTests overlaps;
  std::vector<Readings> readings(levels.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < levels.size(); ++i) {
      // Polygons take a thousand times what a level takes, and no branch predictor learns them by heart.
      WorldState& timed = levels[i].polygons ? solved : refined;
      find(timed, levels[i], dt_s);
      bool room = true;
      readings[i].refine_ns.push_back(nanoseconds([&] { room = refine_all(timed, false); }) / pairs_of(timed));
      readings[i].overlap_ns.push_back(nanoseconds([&] { overlaps.run(timed, levels[i].level); }) / pairs_of(timed));
      find(solved, levels[i], dt_s);
      room = refine_all(solved, true) && room;
      if (!room) return Error{ErrorKind::CapacityFull, "states: their fronts have no room"};
      // Once to fetch what refinement has driven out of the cache.
      answer_all(solved, dt_s);
      const double answers_ns = nanoseconds([&] {
        for (int again = 0; again < kAnswers; ++again) answer_all(solved, dt_s);
      });
      readings[i].response_ns.push_back(answers_ns / kAnswers / pairs_of(solved));
    }
  }
  std::vector<PairCost> costs;
  for (Readings& r : readings) costs.push_back({median(r.refine_ns), median(r.overlap_ns), median(r.response_ns)});
  return costs;
}

}  // namespace poise::simulation
