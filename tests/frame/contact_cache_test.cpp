// SPDX-License-Identifier: MIT
#include "world/contact_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "dynamics/rotation.h"
#include "frame/run_frame.h"
#include "scenes.h"
#include "verify/world_access.h"
#include "world/renew_points.h"

namespace poise {
namespace {

using collision::ManifoldPoint;
using collision::Pose;

TEST(CachedPoint, FollowsBothBodies) {
  const Pose a{Vec3(1, 2, 3), dynamics::rotation_by(Vec3(0.3, -0.2, 0.5)).toRotationMatrix()};
  const Pose b{Vec3(1.5, 2.2, 4), dynamics::rotation_by(Vec3(-0.1, 0.4, 0.2)).toRotationMatrix()};
  const ManifoldPoint manifold_point{a.rotation.transpose() * Vec3::UnitZ(), Vec3(0.1, 0.2, 0.3), 0.01, 0.03};
  std::array<solver::ContactPoint, simulation::kPointsOfPair> points;
  std::array<solver::ContactForce, simulation::kForcesOfPair> forces;
  std::array<double, simulation::kPointsOfPair> gaps_m{};
  simulation::renew_points({a, b}, {{&manifold_point}, 1, points.data(), forces.data(), nullptr, nullptr, 0, 0},
                           gaps_m);
  const solver::ContactPoint& cached = points[0];
  EXPECT_DOUBLE_EQ(gaps_m[0], 0.01);
  const solver::PlacedPoint here = solver::placed_point(a, b, cached);
  EXPECT_NEAR(here.gap_m, 0.01, 1e-14);
  EXPECT_NEAR(here.certain_separation_m, 0.03, 1e-14);
  EXPECT_LT((here.arm_m - a.rotation * manifold_point.point_m).norm(), 1e-14);
  // If both move and rotate equally, nothing changes. If one moves along the normal, the separation changes.
  const Mat3 turn = dynamics::rotation_by(Vec3(0.7, 0.1, -0.4)).toRotationMatrix();
  const Pose turned_a{turn * a.position_m, turn * a.rotation};
  const Pose turned_b{turn * b.position_m, turn * b.rotation};
  EXPECT_NEAR(solver::placed_point(turned_a, turned_b, cached).gap_m, 0.01, 1e-14);
  EXPECT_LT((solver::placed_point(turned_a, turned_b, cached).normal - turn * Vec3::UnitZ()).norm(), 1e-14);
  const Pose lifted{b.position_m + Vec3(0.02, 0, 0.05), b.rotation};
  EXPECT_NEAR(solver::placed_point(a, lifted, cached).gap_m, 0.06, 1e-14);
}

TEST(PointCache, PairsWithPointsAndNoOthersHaveASlotAndNoTwoTheSame) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.2);
  stage.jacks(30, 3.5);
  StepInput input;
  input.dt_s = 1.0 / 60;
  std::size_t with_points = 0;
  std::size_t without = 0;
  std::size_t moved = 0;
  for (int i = 0; i < 120; ++i) {
    stage.world.step(input);
    const simulation::ContactCache& cache = simulation::WorldAccess::of(stage.world).cache;
    using simulation::PointCache;
    std::vector<std::uint32_t> slots = cache.points.released;
    for (std::size_t size = 0; size < PointCache::kSizes; ++size) {
      for (const std::uint32_t slot : cache.points.free[size]) ASSERT_EQ(PointCache::size_of(slot), size);
      slots.insert(slots.end(), cache.points.free[size].begin(), cache.points.free[size].end());
    }
    for (const simulation::CachedPair& pair : cache.pairs) {
      ASSERT_EQ(pair.slot != simulation::kNoSlot, pair.point_count > 0);
      ++(pair.point_count > 0 ? with_points : without);
      if (pair.point_count == 0) continue;
      const std::size_t room = PointCache::room_of(pair.slot);
      ASSERT_LE(pair.point_count, room);
      moved += room > 2 ? 1 : 0;
      slots.push_back(pair.slot);
    }
    // All of the memory, one slot after another.
    std::sort(slots.begin(), slots.end());
    std::size_t end = 0;
    for (const std::uint32_t slot : slots) {
      ASSERT_EQ(PointCache::begin(slot), end);
      end += PointCache::room_of(slot);
    }
    ASSERT_EQ(end, cache.points.points.size());
    ASSERT_EQ(end, cache.points.forces.size());
  }
  EXPECT_GT(moved, 0U) << "no pair has more points than the smallest slot has room for";
  EXPECT_GT(with_points, 0U);
  EXPECT_GT(without, 0U);
}

// The contact cache of a pile persists through frames that may refine little or nothing.
TEST(CachedPoint, APileStaysAsItIsWhateverLevelsAndBudgetsItGets) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.2);
  stage.material = stage.world.add_material({0.2, 0.5, 1000}).value();
  stage.jacks(30, 3.5);
  StepInput input;
  input.dt_s = 1.0 / 60;
  const auto height_m = [&] {
    double sum = 0;
    for (const BodyId body : stage.bodies) sum += stage.at(body).position_m.z();
    return sum / static_cast<double>(stage.bodies.size());
  };
  for (int i = 0; i < 600; ++i) stage.world.step(input);
  const double settled_m = height_m();
  std::mt19937_64 random(3);
  for (int i = 0; i < 240; ++i) {
    StepInput changed = input;
    if (i < 120) {
      changed.max_level = static_cast<Level>(random() % 3);
    } else {
      changed.budget = i / 10 % 2 == 0 ? Budget::work(0) : Budget::unlimited();
    }
    stage.world.step(changed);
    for (const BodyId body : stage.bodies) ASSERT_LT(stage.at(body).velocity_mps.norm(), 0.2) << i;
  }
  EXPECT_NEAR(height_m(), settled_m, 0.01 * settled_m);
}

// Largest overlap of two of Stage's jacks, sphere by sphere.
double overlap_m(const BodyState& a, const BodyState& b) {
  std::vector<Sphere> spheres = {{Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      spheres.push_back({side * 0.35 * Vec3::Unit(axis), 0.22});
      spheres.push_back({side * 0.68 * Vec3::Unit(axis), 0.18});
    }
  }
  double most = 0;
  for (const Sphere& x : spheres) {
    for (const Sphere& y : spheres) {
      const double distance =
          (a.position_m + a.orientation * x.center_m - b.position_m - b.orientation * y.center_m).norm();
      most = std::max(most, x.radius_m + y.radius_m - distance);
    }
  }
  return most;
}

// A body known by its root sphere alone rests about a third of the way from the end of the sphere to the estimated
// surface.
TEST(CachedPoint, AtLevelZeroABodyRestsBetweenItsSphereAndItsLikelySurface) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0);
  stage.plane(Vec3::UnitZ(), 0.3);
  const ShapeId jack = stage.jack();
  const Shape& shape = *simulation::WorldAccess::of(stage.world).shapes[jack.index].shape;
  const double lift_m = collision::coarsest_lift_m(shape);
  ASSERT_GT(lift_m, 0.02 * shape.bounding_radius_m) << "they are one";
  const BodyId body = stage.add(jack, Vec3(0, 0, 1.6));
  StepInput input = step_of(1.0 / 60);
  input.max_level = 0;
  for (int i = 0; i < 240; ++i) stage.world.step(input);
  // Not exactly a third: a contact point stays as it was found, slightly higher.
  const double sunk_m = 0.3 + static_cast<double>(shape.tree.radius_m[0]) - stage.at(body).position_m.z();
  EXPECT_GT(sunk_m, 0.2 * lift_m);
  EXPECT_LT(sunk_m, 0.5 * lift_m);
}

TEST(CachedPoint, AtLevelZeroItIsKeptWhileItIsSureAndNotHeldBeyond) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.2);
  stage.material = stage.world.add_material({0.2, 0.5, 1000}).value();
  stage.jacks(40, 3.5);
  simulation::WorldState& world = simulation::WorldAccess::of(stage.world);
  StepInput input = step_of(1.0 / 60);
  input.max_level = 0;
  std::size_t cached = 0;
  for (int i = 0; i < 240; ++i) {
    // While it falls, and too late in every third frame, when there is no time at all.
    input.budget = i % 3 == 0 ? Budget::until(SteadyClock::time_point{}) : Budget::unlimited();
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(report.degraded.pairs_reused, 0U);
    cached += report.cached_contacts;
    for (std::size_t k = 0; k < world.outputs.table.size(); ++k) {
      const simulation::ActivePair& pair = world.outputs.table.pairs[k];
      const simulation::CacheUse use = world.outputs.levels.progress[k].cached;
      if (use == simulation::CacheUse::None) continue;
      EXPECT_EQ(pair.cached->level, 0);
      EXPECT_NE(use, simulation::CacheUse::Expired);
      EXPECT_LE(pair.cached->moved_m + pair.margin_m, pair.cached->reach_m);
    }
  }
  EXPECT_GT(cached, 700U) << "a pile at rest finds its contact points anew";
}

// Pairs with a large separation are not refined for many frames. However they move meanwhile, they are refined again
// before they touch.
TEST(CachedSeparation, IsAbandonedBeforeThePairMeets) {
  std::mt19937_64 random(11);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
  std::size_t cached = 0;
  int met = 0;
  for (int round = 0; round < 60; ++round) {
    Stage stage({}, 0);
    const ShapeId jack = stage.jack();
    std::array<double, 14> drawn{};
    for (double& number : drawn) number = unit();
    const BodyId a = stage.add(jack, Vec3::Zero(), Vec3::Zero(), Vec3(drawn[0], drawn[1], drawn[2]),
                               Quat(drawn[3], drawn[4], drawn[5], drawn[6]));
    const BodyId b =
        stage.add(jack, Vec3(1.8, 0.6 * drawn[7], 0.6 * drawn[8]), Vec3(-0.3, 0.1 * drawn[9], 0.1 * drawn[10]),
                  Vec3(drawn[11], drawn[12], drawn[13]), Quat(1, drawn[9], drawn[7], drawn[8]));
    for (int i = 0; i < 240; ++i) {
      const FrameReport report = stage.world.step(step_of(1.0 / 60));
      cached += report.cached_separations;
      met += report.contact_pairs > 0 ? 1 : 0;
      // A step at 0.3 m/s and half a radian a second closes at most 1 cm.
      ASSERT_LT(overlap_m(stage.at(a), stage.at(b)), 5e-3) << round << " after " << i;
    }
  }
  EXPECT_GT(cached, 500U) << "clearances are used";
  EXPECT_GT(met, 100) << "and pairs meet";
}

// A shaken pile with cached pairs, beside one that is set to the state of the first before every step and so has no
// cached pairs.
TEST(CachedPairs, AnswersAStirredPileAsOneThatStartsAnewEachFrame) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage cached(settings, 0.2);
  Stage anew(settings, 0.2);
  for (Stage* stage : {&cached, &anew}) {
    stage->material = stage->world.add_material({0.2, 0.5, 1000}).value();
    stage->jacks(14, 2.5);
  }
  std::mt19937_64 random(5);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
  std::size_t compared = 0;
  std::size_t from_memory = 0;
  double difference_m = 0;
  for (int i = 0; i < 1000; ++i) {
    if (i % 50 == 0) {
      std::array<double, 3> push{};
      for (double& number : push) number = unit();
      const BodyId body = cached.bodies[static_cast<std::size_t>(i / 50) % cached.bodies.size()];
      BodyState state = cached.at(body);
      state.velocity_mps += 2.0 * Vec3(push[0], push[1], 1 + push[2]);
      ASSERT_TRUE(cached.world.set_state(body, state));
    }
    for (std::size_t k = 0; k < cached.bodies.size(); ++k) {
      const BodyState here = cached.at(cached.bodies[k]);
      BodyState elsewhere = here;
      elsewhere.position_m.x() += 1;
      ASSERT_TRUE(anew.world.set_state(anew.bodies[k], elsewhere));
      ASSERT_TRUE(anew.world.set_state(anew.bodies[k], here));
    }
    const FrameReport report = cached.world.step(step_of(1.0 / 60));
    from_memory += report.cached_separations + report.cached_contacts;
    const FrameReport fresh = anew.world.step(step_of(1.0 / 60));
    ASSERT_EQ(fresh.cached_separations + fresh.cached_contacts, 0U);
    // All solved pairs, whether they touch or may touch.
    const auto solved = [](Stage& stage) {
      const simulation::WorldState& world = simulation::WorldAccess::of(stage.world);
      return simulation::list_contacts(simulation::publish_input(world), world.cache.points, {},
                                       simulation::ContactListing::Solved);
    };
    const std::vector<Contact> of_kept = solved(cached);
    const std::vector<Contact> of_anew = solved(anew);
    const auto contact_of = [](const std::vector<Contact>& contacts, const Contact& wanted) -> const Contact* {
      for (const Contact& contact : contacts) {
        if (contact.a == wanted.a && contact.b == wanted.b) return &contact;
      }
      return nullptr;
    };
    for (const Contact& contact : of_anew) {
      const Contact* const same = contact_of(of_kept, contact);
      if (same == nullptr) {
        ASSERT_GT(contact.gap_m, -1e-3) << "overlooked in frame " << i;
        continue;
      }
      ++compared;
      difference_m += std::abs(same->gap_m - contact.gap_m);
    }
    for (const Contact& contact : of_kept) {
      if (contact_of(of_anew, contact) == nullptr) {
        ASSERT_GT(contact.gap_m, -1e-3) << "made up in frame " << i;
      }
    }
  }
  EXPECT_GT(compared, 20000U);
  EXPECT_LT(difference_m / static_cast<double>(compared), 5e-4);
  EXPECT_GT(from_memory, compared / 2);
}

// A frame that grows the pair cache copies all of it, at the moment when a pile forms.
TEST(PairCapacity, IsThereBeforeAHeapForms) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0);
  stage.jacks(200, 4);
  stage.world.step(step_of(1.0 / 60));
  const simulation::WorldState& state = simulation::WorldAccess::of(stage.world);
  const std::size_t pairs_room = state.outputs.table.pairs.capacity();
  const std::size_t places_room = state.cache.points.points.capacity();
  const std::size_t at_first = state.outputs.table.pairs.size();
  std::size_t most = 0;
  for (int i = 0; i < 240; ++i) {
    stage.world.step(step_of(1.0 / 60));
    most = std::max(most, state.outputs.table.pairs.size());
  }
  EXPECT_GT(most, 2 * at_first) << "no heap";
  EXPECT_EQ(state.outputs.table.pairs.capacity(), pairs_room);
  EXPECT_EQ(state.cache.points.points.capacity(), places_room);
}

TEST(PairCapacity, GrowsByMoreThanABodyAtATime) {
  Stage stage({}, 0);
  const ShapeId ball = stage.ball(0.1);
  const simulation::WorldState& state = simulation::WorldAccess::of(stage.world);
  int grown = 0;
  std::size_t room = 0;
  for (int i = 0; i < 256; ++i) {
    stage.add(ball, Vec3(i, 0, 0));
    stage.world.step(step_of(1.0 / 60));
    grown += state.outputs.table.pairs.capacity() != room ? 1 : 0;
    room = state.outputs.table.pairs.capacity();
  }
  EXPECT_GE(room, 256U * 6);
  EXPECT_LE(grown, 10);
}

}  // namespace
}  // namespace poise
