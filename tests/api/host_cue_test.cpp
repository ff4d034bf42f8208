// SPDX-License-Identifier: MIT
#include "poise/scheduler/host_cue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "frame/scenes.h"

namespace poise {
namespace {

constexpr std::uint64_t kHero = 7;
constexpr int kFrames = 50;

bool has_hero(const scheduler::UserData& user_data) { return user_data.a == kHero || user_data.b == kHero; }

double heroes_first(const scheduler::PairView& view, void* context) noexcept {
  if (context != nullptr) static_cast<std::atomic<int>*>(context)->fetch_add(1);
  return has_hero(view.user_data) ? 1e4 : 1e-4;
}
double no_number(const scheduler::PairView&, void*) noexcept { return std::numeric_limits<double>::quiet_NaN(); }
double heroes_alone(const scheduler::FrameFacts&, const scheduler::PairChain& chain, const scheduler::PairCues& cues,
                    void*) noexcept {
  return has_hero(chain.user_data) ? 10.0 * static_cast<double>(cues.host) : 0.0;
}

struct Outcome {
  double heroes = 0, others = 0;  ///< mean completed level of the contacts
  std::size_t refused = 0, left = 0;
  std::vector<std::uint64_t> hashes;
  std::vector<FrameDecisions> decisions;
  friend bool operator==(const Outcome& x, const Outcome& y) {
    return x.heroes == y.heroes && x.others == y.others && x.hashes == y.hashes;
  }
};

/// Jacks that fall into a tray, every fourth one a hero, with work for one or two levels a frame.
Outcome run(const scheduler::Policy& policy, int threads, const std::vector<FrameDecisions>* replay = nullptr,
            bool view = false) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.policy = policy;
  settings.threads = threads;
  settings.executor = ExecutorKind::Threads;
  Stage stage(settings, 0.2);
  stage.jacks(60, 4.0);
  for (std::size_t i = 0; i < stage.bodies.size(); i += 4)
    EXPECT_TRUE(stage.world.set_user_data(stage.bodies[i], kHero));
  StepInput input = step_of(1.0 / 60);
  if (view)
    input.view = {true, Vec3(8, -8, 5), Vec3(-1, 1, -0.5).normalized(), Vec3::UnitZ(),
                  0.87, 1.78,           Vec3(-1, 1, -0.5).normalized()};
  input.budget = Budget::work(12);
  input.record = replay == nullptr;
  Outcome outcome;
  double count[2] = {0, 0};
  double sum[2] = {0, 0};
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    if (replay != nullptr) input.replay = &(*replay)[frame];
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(report.status, StepStatus::Done);
    outcome.refused += report.cues_refused;
    outcome.left += report.pairs_left;
    outcome.hashes.push_back(stage.world.state_hash());
    outcome.decisions.emplace_back();
    stage.world.decisions(outcome.decisions.back());
    for (const Contact& contact : stage.world.contacts()) {
      const bool hero =
          stage.world.user_data(contact.a).value() == kHero || stage.world.user_data(contact.b).value() == kHero;
      count[hero ? 0 : 1] += 1;
      sum[hero ? 0 : 1] += static_cast<double>(contact.level);
    }
  }
  outcome.heroes = sum[0] / std::max(1.0, count[0]);
  outcome.others = sum[1] / std::max(1.0, count[1]);
  EXPECT_GT(count[0], 20);
  EXPECT_GT(count[1], 20);
  return outcome;
}

TEST(HostCue, PrefersWhatTheHostPrefersWhereWorkIsShort) {
  const Outcome plain = run({}, 1);
  scheduler::Policy policy;
  std::atomic<int> calls = 0;
  policy.cue = {heroes_first, &calls};
  const Outcome told = run(policy, 1);
  EXPECT_GT(plain.left, 0U) << "no work is short";
  EXPECT_GT(calls, 0);
  EXPECT_EQ(told.refused, 0U);
  EXPECT_GT(told.heroes - told.others, plain.heroes - plain.others + 0.2);
  policy.host = 0;  // a weight of 0 turns the cue off
  EXPECT_EQ(run(policy, 1), plain);
}

TEST(HostCue, GivesTheSameBitsOnAnyThreads) {
  scheduler::Policy policy;
  policy.cue.function = heroes_first;
  EXPECT_EQ(run(policy, 1), run(policy, 2));
}

TEST(HostCue, ThatGivesNoNumberIsCountedAndChangesNothing) {
  scheduler::Policy policy;
  policy.cue.function = no_number;
  const Outcome told = run(policy, 2);
  EXPECT_GT(told.refused, 0U);
  EXPECT_EQ(told, run({}, 1));
}

TEST(HostCue, OfARecordedRunIsNotNeededToReplayIt) {
  scheduler::Policy policy;
  policy.cue.function = heroes_first;
  const Outcome told = run(policy, 2);
  EXPECT_EQ(run({}, 1, &told.decisions).hashes, told.hashes);
  EXPECT_EQ(run(policy, 1, &told.decisions).hashes, told.hashes);
  const Outcome plain = run({}, 1);
  EXPECT_NE(plain.hashes, told.hashes);
  EXPECT_EQ(run(policy, 2, &plain.decisions).hashes, plain.hashes);
}

/// Checks that the values passed to a cue are those of its documentation.
double check_view(const scheduler::PairView& view, void* context) noexcept {
  const auto norm = [](double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); };
  const auto& [x, y, z] = view.point_m;
  const double length = norm(view.normal[0], view.normal[1], view.normal[2]);
  const double distance = norm(x - 8, y + 8, z - 5);
  const bool sound = std::abs(length - 1) < 1e-9 && view.extent_m > 0 && view.closing_mps >= 0 && view.has_view &&
                     std::abs(view.distance_m - distance) < 1e-9 && view.angle_radpm > 0 &&
                     view.eccentricity_rad >= 0 && view.eccentricity_rad < 3.1416 && view.importance == 1;
  if (!sound) static_cast<std::atomic<int>*>(context)->fetch_add(1);
  return 1;
}

TEST(HostCue, SeesThePairAsTheViewerDoes) {
  std::atomic<int> wrong = 0;
  scheduler::Policy policy;
  policy.cue = {check_view, &wrong};
  run(policy, 1, nullptr, true);
  EXPECT_EQ(wrong, 0);
}

TEST(HostPolicy, DecidesAloneWhatIsRefined) {
  scheduler::Policy policy;
  policy.kind = scheduler::PolicyKind::Custom;
  policy.custom.function = heroes_alone;
  const Outcome told = run(policy, 1);
  const Outcome plain = run({}, 1);
  EXPECT_GT(told.heroes - told.others, plain.heroes - plain.others + 0.2);
  EXPECT_EQ(run(policy, 2), told);
  EXPECT_EQ(run({}, 1, &told.decisions).hashes, told.hashes);
}

}  // namespace
}  // namespace poise
