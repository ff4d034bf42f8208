// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "geometry/meshes.h"
#include "poise/world.h"
#include "query/body_surface.h"
#include "query/brute_force.h"

namespace poise {
namespace {

using query::BodySurface;
using query::SurfacePoint;

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Balls, unions of balls and meshes, at random positions and orientations over a plane.
struct Crowd {
  World world;
  std::vector<ShapePtr> shapes;
  std::vector<BodyId> bodies;

  explicit Crowd(int count, std::uint64_t seed = 1) : world(World::create(settings()).value()) {
    std::mt19937_64 random(seed);
    const MaterialId material = world.add_material({}).value();
    const std::vector<Sphere> spheres = {{Vec3(0.3, 0, 0), 0.3}, {Vec3(-0.3, 0.1, 0), 0.2}, {Vec3(0, 0.5, 0.2), 0.25}};
    shapes = {make_sphere_shape(0.4).value(), make_spheres_shape(spheres).value(),
              test::mesh_shape(test::box_mesh({0.8, 0.5, 0.6})), test::mesh_shape(test::torus_mesh(0.4, 0.15, 24, 12)),
              make_plane_shape(Vec3::UnitZ(), -8).value()};
    std::vector<ShapeId> ids;
    for (const ShapePtr& shape : shapes) ids.push_back(world.add_shape(shape));
    for (int i = 0; i < count; ++i) {
      BodyDefinition body;
      const std::size_t shape = i == 0 ? 4 : static_cast<std::size_t>(i) % 4;
      body.shape = ids[shape];
      body.material = material;
      body.motion = shape == 4 ? MotionType::Static : MotionType::Dynamic;
      if (shape != 4) {
        body.position_m = test::vector_within(random, 6);
        body.orientation = test::turn(random);
        body.velocity_mps = test::vector_within(random, 5);
      }
      body.group = 1U << (i % 3);
      bodies.push_back(world.add_body(body).value());
    }
  }
  static WorldSettings settings() {
    WorldSettings settings;
    settings.threads = 1;
    settings.max_front_entries = 1U << 14U;
    settings.gravity_mps2 = Vec3(0, 0, -9.81);
    return settings;
  }
  struct Local {
    BodyId id;
    BodySurface surface;
    Mat3 rotation;
    Vec3 position;
    Vec3 into(const Vec3& p) const { return rotation.transpose() * (p - position); }
    Vec3 turned(const Vec3& d) const { return (rotation.transpose() * d).normalized(); }
  };
  std::vector<Local> locals() const {
    std::vector<Local> all;
    for (const BodyId id : world.bodies()) {
      const BodyState state = world.state(id).value();
      all.push_back({id, BodySurface(world.shape(id).value()), state.orientation.toRotationMatrix(), state.position_m});
    }
    return all;
  }
};

struct Best {
  BodyId id;
  double distance_m = kFar;
  void take(BodyId candidate, const std::optional<SurfacePoint>& found) {
    if (!found || std::abs(found->distance_m) >= std::abs(distance_m)) return;
    distance_m = found->distance_m;
    id = candidate;
  }
};

/// Compares every query with querying each body separately.
void expect_like_one_by_one(const Crowd& crowd, std::mt19937_64& random) {
  const std::vector<Crowd::Local> locals = crowd.locals();
  const Vec3 from = test::vector_within(random, 9);
  const Vec3 d = test::direction(random);
  const double radius = test::uniform(random, 0.05, 1.5);
  Best ray;
  Best sphere;
  Best near;
  std::vector<BodyId> in_ball;
  std::vector<BodyId> in_box;
  const Mat3 turn = test::turn(random).toRotationMatrix();
  const Vec3 half = test::vector_within(random, 2).cwiseAbs();
  for (const Crowd::Local& body : locals) {
    ray.take(body.id, body.surface.cast_ray(body.into(from), body.turned(d), kFar, false));
    sphere.take(body.id, body.surface.cast_sphere(body.into(from), radius, body.turned(d), kFar));
    near.take(body.id, body.surface.closest(body.into(from), kFar));
    if (body.surface.overlaps_ball(body.into(from), radius)) in_ball.push_back(body.id);
    if (body.surface.overlaps_box(turn.transpose() * body.rotation, turn.transpose() * (body.position - from), half))
      in_box.push_back(body.id);
  }
  const auto hit = crowd.world.cast_ray({from, 3 * d}).value();
  ASSERT_EQ(hit.has_value(), ray.distance_m < kFar);
  if (hit) {
    EXPECT_EQ(hit->body, ray.id);
    EXPECT_NEAR(hit->distance_m, ray.distance_m, 1e-12);
    EXPECT_LT((hit->point_m - from - hit->distance_m * d).norm(), 1e-10);
    EXPECT_NEAR(hit->normal.norm(), 1, 1e-15);
  }
  const auto touch = crowd.world.cast_sphere({from, radius, 3 * d, 100}).value();
  ASSERT_EQ(touch.has_value(), sphere.distance_m < 100);
  if (touch) {
    EXPECT_NEAR(touch->distance_m, sphere.distance_m, 1e-12);
    EXPECT_NEAR(touch->fraction, touch->distance_m / 100, 1e-15);
    if (!touch->overlaps_at_start) {
      EXPECT_EQ(touch->body, sphere.id);
      EXPECT_NEAR((from + touch->distance_m * d - touch->point_m).norm(), radius, 1e-9);
    }
  }
  const auto closest = crowd.world.closest_point(from, kFar).value();
  ASSERT_TRUE(closest);
  EXPECT_EQ(closest->body, near.id);
  EXPECT_NEAR(closest->distance_m, near.distance_m, 1e-12);
  const ClosestPoint of_it = crowd.world.closest_point(near.id, from).value();
  EXPECT_EQ(of_it.point_m, closest->point_m);
  std::vector<BodyId> found;
  ASSERT_TRUE(crowd.world.overlap_sphere(from, radius, found));
  EXPECT_EQ(found, in_ball);
  ASSERT_TRUE(crowd.world.overlap_box({from, half, Quat(turn)}, found));
  EXPECT_EQ(found, in_box);
}

TEST(WorldQueries, AnswerAsBodiesAskedOneByOne) {
  for (const int count : {1, 2, 5, 60, 400}) {
    const Crowd crowd(count);
    std::mt19937_64 random(static_cast<std::uint64_t>(count));
    for (int i = 0; i < 40; ++i) expect_like_one_by_one(crowd, random);
  }
}

TEST(WorldQueries, FollowStepsAndBodiesThatComeMoveAndGo) {
  Crowd crowd(80);
  std::mt19937_64 random(3);
  StepInput input;
  input.dt_s = 0.2;  // long enough for a box with an outdated position to be detected
  for (int frame = 0; frame < 12; ++frame) {
    expect_like_one_by_one(crowd, random);
    ASSERT_EQ(crowd.world.step(input).status, StepStatus::Done);
    for (int i = 0; i < 10; ++i) expect_like_one_by_one(crowd, random);
    const BodyId gone = crowd.bodies[static_cast<std::size_t>(5 * frame + 1)];
    ASSERT_TRUE(crowd.world.remove_body(gone));
    expect_like_one_by_one(crowd, random);
    const BodyId moved = crowd.bodies[static_cast<std::size_t>(5 * frame + 2)];
    BodyState state = crowd.world.state(moved).value();
    state.position_m += Vec3(0, 0, 1);
    ASSERT_TRUE(crowd.world.set_state(moved, state));
    expect_like_one_by_one(crowd, random);
  }
}

TEST(WorldQueries, ChangeNothingOfTheState) {
  Crowd asked(50);
  Crowd alone(50);
  std::mt19937_64 random(4);
  for (int frame = 0; frame < 5; ++frame) {
    asked.world.step({});
    alone.world.step({});
    expect_like_one_by_one(asked, random);
    EXPECT_EQ(asked.world.state_hash(), alone.world.state_hash());
  }
}

TEST(WorldQueries, SeeTheGroupsOfTheFilterAndNotTheBodyToIgnore) {
  World world = World::create(Crowd::settings()).value();
  BodyDefinition body;
  body.shape = world.add_shape(make_sphere_shape(0.5).value());
  body.material = world.add_material({}).value();
  std::vector<BodyId> row;
  for (int i = 0; i < 4; ++i) {
    body.position_m = Vec3(2 * i, 0, 0);
    body.group = i == 1 ? 2 : 1;
    body.collides_with = i == 2 ? 4 : 0xffffffffU;
    row.push_back(world.add_body(body).value());
  }
  const Ray ray{Vec3(-5, 0, 0), Vec3::UnitX()};
  QueryFilter filter;
  EXPECT_EQ(world.cast_ray(ray, filter).value().value().body, row[0]);
  filter.ignore = row[0];
  EXPECT_EQ(world.cast_ray(ray, filter).value().value().body, row[1]);
  filter.collides_with = 1;
  EXPECT_EQ(world.cast_ray(ray, filter).value().value().body, row[2]);
  filter.group = 1;
  EXPECT_EQ(world.cast_ray(ray, filter).value().value().body, row[3]);
  filter.collides_with = 8;
  EXPECT_FALSE(world.cast_ray(ray, filter).value());
  std::vector<BodyId> found;
  filter = {.collides_with = 2};
  ASSERT_TRUE(world.overlap_sphere(Vec3(3, 0, 0), 10, found, filter));
  EXPECT_EQ(found, std::vector<BodyId>{row[1]});
  // Of bodies at the same distance the one with the lowest slot is returned.
  ASSERT_TRUE(world.set_groups(row[1], 1, 0xffffffffU));
  EXPECT_EQ(world.closest_point(Vec3(1, 0, 0), kFar).value().value().body, row[0]);
}

TEST(WorldQueries, OfAnEmptyWorldFindNothing) {
  const World world = World::create(Crowd::settings()).value();
  std::vector<BodyId> found = {BodyId{}};
  EXPECT_FALSE(world.cast_ray({}).value());
  EXPECT_FALSE(world.cast_sphere({}).value());
  EXPECT_FALSE(world.closest_point(Vec3::Zero(), kFar).value());
  ASSERT_TRUE(world.overlap_sphere(Vec3::Zero(), 1, found));
  EXPECT_TRUE(found.empty());
}

TEST(WorldQueries, RefuseBadInputWithFieldValueAndRule) {
  const Crowd crowd(3);
  const World& world = crowd.world;
  std::vector<BodyId> found;
  const auto refused = [](const auto& result, const char* message) {
    ASSERT_FALSE(result.ok());
    EXPECT_NE(result.error().message.find(message), std::string::npos) << result.error().message;
  };
  refused(world.cast_ray({Vec3(kNan, 0, 0)}), "origin_m = [nan, 0, 0], each must be finite");
  refused(world.cast_ray({Vec3(0, 2e12, 0)}), "origin_m = [0, 2000000000000, 0]");
  refused(world.cast_ray({Vec3::Zero(), Vec3::Zero()}), "direction = [0, 0, 0], must be finite and not zero");
  refused(world.cast_ray({Vec3::Zero(), Vec3(0, kFar, 0)}), "direction = [0, inf, 0]");
  refused(world.cast_ray({Vec3::Zero(), Vec3::UnitX(), -1}), "max_distance_m = -1, must be >= 0");
  refused(world.cast_ray({Vec3::Zero(), Vec3::UnitX(), kNan}), "max_distance_m = nan, must be >= 0");
  refused(world.cast_sphere({Vec3::Zero(), -0.1}), "radius_m = -0.1, must be in [0,");
  refused(world.cast_sphere({Vec3::Zero(), kNan}), "radius_m = nan");
  refused(world.cast_sphere({Vec3::Zero(), 1, Vec3::Zero()}), "direction = [0, 0, 0]");
  refused(world.overlap_sphere(Vec3(0, 0, kFar), 1, found), "center_m = [0, 0, inf]");
  refused(world.overlap_sphere(Vec3::Zero(), -1, found), "radius_m = -1");
  refused(world.overlap_box({Vec3::Zero(), Vec3(1, -1, 1)}, found), "half_extents_m = -1");
  refused(world.overlap_box({Vec3::Zero(), Vec3::Ones(), Quat(0, 0, 0, 0)}, found), "orientation_wxyz = [0, 0, 0, 0]");
  refused(world.closest_point(Vec3(kNan, 0, 0), kFar), "point_m = [nan, 0, 0]");
  refused(world.closest_point(Vec3::Zero(), -1), "max_distance_m = -1");
  const auto stale = world.closest_point(BodyId{77, 1}, Vec3::Zero());
  ASSERT_FALSE(stale);
  EXPECT_EQ(stale.error().kind, ErrorKind::StaleHandle);
  refused(world.closest_point(crowd.bodies[0], Vec3(kNan, 0, 0)), "point_m = [nan, 0, 0]");
}

TEST(WorldQueries, TakeADirectionOfAnyLength) {
  const Crowd crowd(60);
  const Vec3 d = Vec3(1, -2, 0.5);
  const Vec3 from = crowd.world.state(crowd.bodies[4]).value().position_m - 4 * d;
  const auto expected = crowd.world.cast_ray({from, d.normalized()}).value();
  ASSERT_TRUE(expected);
  for (const double length : {1e-300, 1e-160, 1.0, 1e160, 1e300}) {
    const auto hit = crowd.world.cast_ray({from, length * d}).value();
    ASSERT_TRUE(hit) << length;
    EXPECT_NEAR(hit->distance_m, expected->distance_m, 1e-12);
  }
}

TEST(WorldQueries, OfManyThreadsAtOnceAreThoseOfOne) {
  Crowd crowd(300);
  for (int frame = 0; frame < 3; ++frame) {
    crowd.world.step({});
    constexpr int kThreads = 4;
    constexpr int kRays = 200;
    const auto cast = [&](int number) {
      std::mt19937_64 random(static_cast<std::uint64_t>(number));
      std::vector<double> distances;
      for (int i = 0; i < kRays; ++i) {
        const Vec3 from = test::vector_within(random, 9);
        const auto hit = crowd.world.cast_ray({from, test::direction(random)}).value();
        distances.push_back(hit ? hit->distance_m : -1);
      }
      return distances;
    };
    // The index is outdated here, so that the threads race to update it.
    std::vector<std::vector<double>> answers(kThreads);
    {
      std::vector<std::jthread> threads;
      for (int t = 0; t < kThreads; ++t) {
        threads.emplace_back([&, t] { answers[static_cast<std::size_t>(t)] = cast(t); });
      }
    }
    for (int t = 0; t < kThreads; ++t) EXPECT_EQ(answers[static_cast<std::size_t>(t)], cast(t));
  }
}

}  // namespace
}  // namespace poise
