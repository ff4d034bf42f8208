// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "frame/scenes.h"
#include "geometry/meshes.h"

namespace poise {
namespace {

// Numbers at the ends of what the World accepts, and some between.
constexpr std::array kMassesKg = {1e-18, 1e-9, 1e-3, 1.0, 1e9, 1e18};
constexpr std::array kSizesM = {1e-6, 1e-3, 1.0, 1e3, 1e6};
constexpr std::array kStepsS = {1e-9, 1e-3, 1.0 / 60, 1.0, 1000.0};
constexpr std::array kSpeeds = {0.0, 0.0, 1.0, 1e4, 1e8, 1e9};
constexpr std::array kSpreads = {0.0, 0.5, 1.0, 100.0, 1e6, 1e12};
constexpr std::array kGravities = {0.0, 9.81, 9.81, 1e9};
constexpr std::array kForces = {0.0, 0.0, 1.0, 1e12, 1e30};

// The limits that poise/world.h gives for BodyState.
bool is_in_range(const BodyState& state) {
  const auto within = [](const Vec3& value, double most) {
    return value.allFinite() && value.cwiseAbs().maxCoeff() <= most;
  };
  return within(state.position_m, 1e12) && within(state.velocity_mps, 1e9) &&
         within(state.angular_velocity_radps, 1e9) && std::abs(state.orientation.norm() - 1) < 1e-9;
}

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  template <std::size_t N>
  double from(const std::array<double, N>& values) {
    return values[random_() % N];
  }
  double unit() { return static_cast<double>(random_() >> 11U) * 0x1.0p-53 - 0.5; }
  Vec3 vector(double most) {
    const double x = unit(), y = unit(), z = unit();
    return 2 * most * Vec3(x, y, z);
  }
  bool coin() { return (random_() & 1U) != 0; }

 private:
  std::mt19937_64 random_;
};

// Cubes and needles. Each is built once, since trees take longer than all steps.
const ShapePtr& box(double size_m, bool cube) {
  static std::map<std::pair<double, bool>, ShapePtr> built;
  ShapePtr& shape = built[{size_m, cube}];
  if (shape == nullptr) {
    const double thin = cube ? 1 : 1e-3;
    TreeBuildOptions options;
    options.depth = 1;
    shape = make_mesh_shape(test::box_mesh(Vec3(size_m, thin * size_m, thin * size_m)), options).value();
  }
  return shape;
}

std::string described(const BodyState& state) {
  std::ostringstream text;
  text << "at " << state.position_m.transpose() << ", turned " << state.orientation.coeffs().transpose() << ", "
       << state.velocity_mps.transpose() << " m/s, " << state.angular_velocity_radps.transpose() << " rad/s";
  return text.str();
}

// A world of bodies at these ends, pushed and stepped.
class ExtremeWorld {
 public:
  explicit ExtremeWorld(std::uint64_t seed) : draw_(seed), stage_(settings()) {
    const double restitution = draw_.coin() ? 1 : 0;
    stage_.material = stage_.world.add_material({restitution, draw_.coin() ? 1e6 : 0, 1000}).value();
    if (draw_.coin()) stage_.tray(10);
    const double spread_m = draw_.from(kSpreads);
    for (int i = 0; i < 24; ++i) add(spread_m);
    // A time of impact among such spins is searched to its work limit, which takes as long as many frames.
    input_.backtracking = seed % 8 == 0;
    input_.polygons = draw_.coin();
    force_n_ = draw_.from(kForces);
  }

  void step(int frame) {
    input_.dt_s = draw_.from(kStepsS);
    if (force_n_ > 0) {
      const BodyId pushed = stage_.bodies[static_cast<std::size_t>(frame) % stage_.bodies.size()];
      const Status applied = stage_.world.apply_force(pushed, draw_.vector(force_n_), stage_.at(pushed).position_m);
      ASSERT_TRUE(applied.ok()) << applied.error().message;
    }
    report_ = stage_.world.step(input_);
    ASSERT_EQ(report_.status, StepStatus::Done);
    out_of_range_ += report_.out_of_range;
    for (const BodyId body : stage_.bodies)
      ASSERT_TRUE(is_in_range(stage_.at(body))) << "body " << body.slot << " " << described(stage_.at(body));
    for (const Contact& contact : stage_.world.contacts())
      ASSERT_TRUE(contact.impulse_ns.allFinite()) << contact.a.slot << ", " << contact.b.slot;
  }
  [[nodiscard]] std::size_t out_of_range() const { return out_of_range_; }

 private:
  WorldSettings settings() {
    WorldSettings made;
    made.threads = 1;
    made.sleeping = draw_.coin();
    made.gravity_mps2 = Vec3(0, 0, -draw_.from(kGravities));
    return made;
  }
  void add(double spread_m) {
    BodyDefinition body;
    const double size_m = draw_.from(kSizesM);
    const double kind = draw_.unit();
    if (kind < -0.25) {
      body.shape = stage_.ball(size_m);
    } else if (kind < 0) {
      const std::vector<Sphere> two = {{Vec3::Zero(), 0.5 * size_m}, {Vec3(size_m, 0, 0), 0.25 * size_m}};
      body.shape = stage_.world.add_shape(make_spheres_shape(two).value());
    } else {
      body.shape = stage_.world.add_shape(box(draw_.coin() ? 1e-3 : 1e3, kind < 0.25));
    }
    body.material = stage_.material;
    body.mass_kg = draw_.from(kMassesKg);
    body.position_m = draw_.vector(spread_m);
    body.velocity_mps = draw_.vector(draw_.from(kSpeeds));
    body.angular_velocity_radps = draw_.vector(draw_.from(kSpeeds));
    stage_.bodies.push_back(stage_.world.add_body(body).value());
  }

  Draw draw_;
  Stage stage_;
  StepInput input_;
  FrameReport report_;
  double force_n_ = 0;
  std::size_t out_of_range_ = 0;
};

TEST(Extremes, StatesAndImpulsesStayInRange) {
  std::size_t out_of_range = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    ExtremeWorld world(seed);
    for (int frame = 0; frame < 6; ++frame) {
      SCOPED_TRACE(frame);
      world.step(frame);
      if (testing::Test::HasFatalFailure()) return;
    }
    out_of_range += world.out_of_range();
  }
  EXPECT_GT(out_of_range, 50U) << "the numbers are not extreme";
}

TEST(Extremes, ABodyThatLeavesTheRangeComesToRestWhereItWasAndIsNamed) {
  WorldSettings settings = one_thread_with_gravity();
  Stage stage(settings, 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  const BodyId first = stage.add(ball, Vec3(0, 0, 0.5));
  const BodyId lost = stage.add(ball, Vec3(0, 0, 1.5));
  const BodyId alone = stage.add(ball, Vec3(5, 0, 1.4));
  for (int i = 0; i < 10; ++i) stage.world.step(step_of(1.0 / 60));
  const BodyState before = stage.at(lost);
  ASSERT_TRUE(stage.world.apply_force(lost, Vec3(0, 0, 1e30), before.position_m).ok());
  const FrameReport report = stage.world.step(step_of(1.0 / 60));
  EXPECT_EQ(report.out_of_range, 1U);
  EXPECT_EQ(report.out_of_range_body, lost);
  const BodyState after = stage.at(lost);
  EXPECT_EQ(after.position_m, before.position_m);
  EXPECT_EQ(after.orientation.coeffs(), before.orientation.coeffs());
  EXPECT_TRUE(after.velocity_mps.isZero(0) && after.angular_velocity_radps.isZero(0));
  for (const Contact& contact : stage.world.contacts()) {
    const bool is_of_lost = contact.a == lost || contact.b == lost;
    EXPECT_EQ(is_of_lost, contact.impulse_ns.isZero(0));
  }
  EXPECT_NEAR(stage.at(alone).velocity_mps.z(), -9.81 * 11 / 60, 1e-9) << "the others go on";
  for (int i = 0; i < 120; ++i) EXPECT_EQ(stage.world.step(step_of(1.0 / 60)).out_of_range, 0U);
  EXPECT_NEAR(stage.at(lost).position_m.z(), 1.5, 0.01) << "and it goes on from where it was";
  EXPECT_NEAR(stage.at(first).position_m.z(), 0.5, 0.01);
}

TEST(Extremes, AKinematicBodyStopsAtTheEndOfTheRange) {
  Stage stage(one_thread_with_gravity());
  BodyDefinition body;
  body.shape = stage.ball(1);
  body.material = stage.material;
  body.motion = MotionType::Kinematic;
  body.position_m = Vec3(9e11, 0, 0);
  body.velocity_mps = Vec3(1e9, 0, 0);
  const BodyId platform = stage.world.add_body(body).value();
  EXPECT_EQ(stage.world.step(step_of(90)).out_of_range, 0U);
  EXPECT_EQ(stage.world.step(step_of(90)).out_of_range, 1U);
  EXPECT_EQ(stage.at(platform).position_m.x(), 9.9e11);
  EXPECT_TRUE(stage.at(platform).velocity_mps.isZero(0));
  EXPECT_EQ(stage.world.step(step_of(90)).out_of_range, 0U);
}

}  // namespace
}  // namespace poise
