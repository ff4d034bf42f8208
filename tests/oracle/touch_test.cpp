// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/mesh/procedural.h"
#include "oracle/random_touch.h"

namespace poise::oracle {
namespace {

OracleMesh shape(const char* name) {
  return OracleMesh::make(geometry::make_procedural_shape(name).value(), 1000).value();
}

double energy_j(const OracleMesh& body, const Quat& orientation, const Vec3& velocity_mps, const Vec3& spin_radps) {
  const Vec3 spin = orientation.conjugate() * spin_radps;
  return 0.5 * body.mass_kg() * velocity_mps.squaredNorm() + 0.5 * spin.dot(body.inertia_kgm2() * spin);
}

TEST(RandomTouches, NoneIsSteppedOverAndEachIsWithinTheTolerance) {
  const OracleMesh a = shape("l");
  const OracleMesh b = shape("slab");
  for (std::uint64_t number = 0; number < 200; ++number) {
    const RandomTouch thrown = random_touch(a, b, {.seed = 5}, number);
    ASSERT_EQ(thrown.touch.outcome, FlightOutcome::Touch);
    EXPECT_EQ(thrown.undecided, 0);
    ASSERT_GT(thrown.touch.nearest.distance_m, 0);
    ASSERT_LE(thrown.touch.nearest.distance_m, touch_tolerance_m(a, b) * (1 + 1e-9));
    const double early_s = thrown.touch.time_s - 1e-3;
    ASSERT_GT(a.distance_m(thrown.a.at(early_s), b, thrown.b.at(early_s)), thrown.touch.nearest.distance_m);
    for (int i = 0; i < 20; ++i) {
      const double time_s = thrown.touch.time_s * i / 20;
      ASSERT_GT(a.distance_m(thrown.a.at(time_s), b, thrown.b.at(time_s)), 0) << "touch " << number;
    }
  }
}

TEST(RandomTouches, AnswersKeepMomentumAndLeaveTheShareOfApproachThatRestitutionSays) {
  const OracleMesh a = shape("l");
  const OracleMesh b = shape("cube");
  for (std::uint64_t number = 0; number < 50; ++number) {
    const RandomTouch t = random_touch(a, b, {.seed = 6}, number);
    const Answer& d = t.answer;
    EXPECT_LT((a.mass_kg() * d.dv_a_mps + b.mass_kg() * d.dv_b_mps).norm(), 1e-9 * a.mass_kg() * d.dv_a_mps.norm());
    const Vec3 point = 0.5 * (t.touch.nearest.on_a_m + t.touch.nearest.on_b_m);
    const auto point_speed = [&](const Placed& at, const Vec3& v, const Vec3& w) {
      return Vec3(v + w.cross(point - at.position_m));
    };
    const Vec3 after = point_speed(t.touch.a, t.a.velocity_mps + d.dv_a_mps, t.a.spin_radps + d.dw_a_radps) -
                       point_speed(t.touch.b, t.b.velocity_mps + d.dv_b_mps, t.b.spin_radps + d.dw_b_radps);
    EXPECT_NEAR(t.touch.nearest.normal.dot(after), -0.5 * d.approach_mps, 1e-9);
    const double before_j = energy_j(a, t.touch.a.orientation, t.a.velocity_mps, t.a.spin_radps) +
                            energy_j(b, t.touch.b.orientation, t.b.velocity_mps, t.b.spin_radps);
    const double after_j =
        energy_j(a, t.touch.a.orientation, t.a.velocity_mps + d.dv_a_mps, t.a.spin_radps + d.dw_a_radps) +
        energy_j(b, t.touch.b.orientation, t.b.velocity_mps + d.dv_b_mps, t.b.spin_radps + d.dw_b_radps);
    // (1 - e^2) v_c^2 / (2 K), with the impulse (1 + e) v_c / K.
    const double impulse_ns = b.mass_kg() * d.dv_b_mps.norm();
    EXPECT_NEAR(before_j - after_j, 0.5 * 0.5 * d.approach_mps * impulse_ns, 1e-9 * before_j);
  }
}

TEST(RandomTouches, DependOnSeedAndNumberAlone) {
  const OracleMesh a = shape("slab");
  const OracleMesh b = shape("cube");
  const RandomTouch once = random_touch(a, b, {.seed = 7}, 12);
  random_touch(a, b, {.seed = 7}, 13);
  const RandomTouch again = random_touch(a, b, {.seed = 7}, 12);
  EXPECT_EQ(once.touch.time_s, again.touch.time_s);
  EXPECT_EQ(once.answer.dw_b_radps, again.answer.dw_b_radps);
  EXPECT_NE(once.touch.time_s, random_touch(a, b, {.seed = 8}, 12).touch.time_s);
  EXPECT_NE(once.touch.time_s, random_touch(a, b, {.seed = 7}, 14).touch.time_s);
  EXPECT_EQ(once.half(), Half::Tune);
  EXPECT_EQ(random_touch(a, b, {.seed = 7}, 13).half(), Half::Report);
}

TEST(RandomTouches, AShiftOfNothingChangesNothingAndASmallOneLittle) {
  const OracleMesh a = shape("slab");
  const OracleMesh b = shape("cube");
  const ThrowOptions options{.seed = 9};
  double changed = 0;
  double whole = 0;
  for (std::uint64_t number = 0; number < 40; ++number) {
    const RandomTouch touch = random_touch(a, b, options, number);
    EXPECT_EQ(shifted_answer(a, b, options, touch, 0, 0).dv_a_mps, touch.answer.dv_a_mps);
    changed += (shifted_answer(a, b, options, touch, 1e-3, 0).dv_a_mps - touch.answer.dv_a_mps).norm();
    whole += touch.answer.dv_a_mps.norm();
  }
  EXPECT_GT(changed, 0);
  EXPECT_LT(changed, 0.1 * whole);
}

}  // namespace
}  // namespace poise::oracle
