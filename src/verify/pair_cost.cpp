// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "frame/world_state.h"
#include "parallel/cpu_clock.h"
#include "verify/pair_probe.h"
#include "verify/pair_stages.h"

namespace poise::simulation {
namespace {

constexpr std::uint32_t kEntries = 1U << 22U;
// Number of pairs whose impulses are timed together: the paper's model reads their fronts, so all of them must fit into
// the capacity.
constexpr std::size_t kSolved = 50;
constexpr int kAnswers = 10;

// The overlap tests alone: fronts in two buffers that are reused for every pair.
class OverlapTests {
 public:
  OverlapTests() {
    for (std::vector<collision::FrontEntry>& front : fronts_) front.resize(kEntriesOfPair);
  }
  void run(const PairStages& stages, Level max_level) {
    const WorldState& world = stages.world();
    const PairRefiner refiner{world.scene(), world.settings.contact};
    for (const ActivePair& pair : stages.frame().table.pairs) {
      const Level deepest =
          collision::deepest_level(*world.bodies.shape[pair.a], *world.bodies.shape[pair.b], max_level);
      fronts_[0][0] = {0, 0};
      std::size_t count = 1;
      for (std::size_t k = 0; k < deepest && count > 0; ++k) {
        const std::span<const collision::FrontEntry> front(fronts_[k % 2].data(), count);
        count =
            collision::expand(frame_of(refiner, posed(stages.frame().motion, pair)), front, fronts_[1 - k % 2]).hits;
      }
    }
  }

 private:
  static constexpr std::size_t kEntriesOfPair = 1U << 19U;
  std::array<std::vector<collision::FrontEntry>, 2> fronts_;
};

// Computes rows and impulses of all pairs; every wrench acts, whatever its separation.
void answer_all(PairStages& stages) {
  stages.make_rows();
  stages.close_gaps();
  stages.solve();
}

template <class Work>
double nanoseconds(Work&& work) {
  const Nanoseconds before = parallel::thread_cpu_time();
  work();
  return static_cast<double>((parallel::thread_cpu_time() - before).count());
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
  Result<World> many = world_of(settings, states, kEntries);
  Result<World> few = world_of(settings, states.first(std::min(kSolved, states.size())), kEntries);
  if (!many || !few) return many ? few.error() : many.error();
  PairStages refined(*many.value().state_);
  PairStages solved(*few.value().state_);
  const auto pairs_of = [](const PairStages& stages) {
    return static_cast<double>(std::max<std::size_t>(stages.frame().table.size(), 1));
  };
  OverlapTests overlaps;
  std::vector<Readings> readings(levels.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < levels.size(); ++i) {
      // Polygons take a thousand times as long as a level, so a branch predictor cannot memorise them. They are timed
      // on the smaller set.
      PairStages& timed = levels[i].polygons ? solved : refined;
      timed.find(levels[i], dt_s);
      bool fits = true;
      readings[i].refine_ns.push_back(nanoseconds([&] { fits = timed.refine_all(false); }) / pairs_of(timed));
      readings[i].overlap_ns.push_back(nanoseconds([&] { overlaps.run(timed, levels[i].level); }) / pairs_of(timed));
      solved.find(levels[i], dt_s);
      fits = solved.refine_all(true) && fits;
      if (!fits) return Error{ErrorKind::CapacityFull, "states: their fronts have no room"};
      // A first run loads the data that refinement evicted from the cache.
      answer_all(solved);
      const double answers_ns = nanoseconds([&] {
        for (int again = 0; again < kAnswers; ++again) answer_all(solved);
      });
      readings[i].response_ns.push_back(answers_ns / kAnswers / pairs_of(solved));
    }
  }
  std::vector<PairCost> costs;
  for (Readings& r : readings) costs.push_back({median(r.refine_ns), median(r.overlap_ns), median(r.response_ns)});
  return costs;
}

}  // namespace poise::simulation
