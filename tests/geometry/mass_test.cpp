// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numbers>

#include "meshes.h"

namespace poise {
namespace {

using test::ball_mesh;
using test::box_mesh;
using test::torus_mesh;
constexpr double kPi = std::numbers::pi;

MassProperties mass_of(const TriangleMesh& mesh) {
  const auto mass = mesh_mass_properties(mesh);
  EXPECT_TRUE(mass.ok()) << mass.error().message;
  return mass.ok() ? mass.value() : MassProperties{};
}

Mat3 box_inertia(const Vec3& s) {
  const Vec3 squares = s.cwiseProduct(s);
  return s.prod() / 12 *
         Vec3(squares.y() + squares.z(), squares.x() + squares.z(), squares.x() + squares.y())
             .asDiagonal()
             .toDenseMatrix();
}

TEST(MassProperties, OfABoxAreItsClosedForm) {
  const Vec3 size(0.3, 2.0, 0.7);
  const MassProperties mass = mass_of(box_mesh(size));
  EXPECT_NEAR(mass.volume_m3, size.prod(), 1e-14 * size.prod());
  EXPECT_LT(mass.center_of_mass_m.norm(), 1e-15);
  EXPECT_LT((mass.inertia_m5 - box_inertia(size)).norm(), 1e-14 * box_inertia(size).norm());
}

TEST(MassProperties, OfATetrahedronAreItsClosedForm) {
  TriangleMesh mesh;
  mesh.vertices_m = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const MassProperties mass = mass_of(mesh);
  EXPECT_NEAR(mass.volume_m3, 1.0 / 6, 1e-16);
  EXPECT_LT((mass.center_of_mass_m - Vec3::Constant(0.25)).norm(), 1e-15);
  // About the corner: diagonal 1/30, products of inertia 1/120; moved to the centre of mass.
  EXPECT_NEAR(mass.inertia_m5(0, 0), 1.0 / 30 - 1.0 / 6 * 2 / 16, 1e-16);
  EXPECT_NEAR(mass.inertia_m5(0, 1), -1.0 / 120 + 1.0 / 6 / 16, 1e-16);
}

TEST(MassProperties, OfAnLAreThoseOfItsTwoBoxes) {
  const MassProperties mass = mass_of(geometry::make_procedural_shape("l").value());
  const Vec3 size_a(0.8, 0.25, 0.25);
  const Vec3 size_b(0.25, 0.55, 0.25);
  const Vec3 at_a(0, -0.275, 0);
  const Vec3 at_b(-0.275, 0.125, 0);
  const double volume = size_a.prod() + size_b.prod();
  const Vec3 center = (size_a.prod() * at_a + size_b.prod() * at_b) / volume;
  Mat3 inertia = box_inertia(size_a) + box_inertia(size_b);
  for (const auto& [size, at] : {std::pair(size_a, at_a), std::pair(size_b, at_b)}) {
    const Vec3 arm = at - center;
    inertia += size.prod() * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
  }
  EXPECT_NEAR(mass.volume_m3, volume, 1e-14);
  EXPECT_LT((mass.center_of_mass_m - center).norm(), 1e-14);
  EXPECT_LT((mass.inertia_m5 - inertia).norm(), 1e-14 * inertia.norm());
}

TEST(MassProperties, OfAFinerBallComeFourTimesCloserToTheBallEachTime) {
  const double volume = 4.0 / 3 * kPi * 8;
  const double moment = 0.4 * volume * 4;
  double last_volume_error = 0;
  double last_moment_error = 0;
  for (int splits = 2; splits <= 5; ++splits) {
    const MassProperties mass = mass_of(ball_mesh(2, splits));
    const double volume_error = volume - mass.volume_m3;
    const double moment_error = moment - mass.inertia_m5(0, 0);
    EXPECT_GT(volume_error, 0);
    EXPECT_LT((mass.inertia_m5 - mass.inertia_m5(0, 0) * Mat3::Identity()).norm(), 1e-12 * moment);
    if (splits > 2) {
      EXPECT_NEAR(last_volume_error / volume_error, 4, 0.2);
      EXPECT_NEAR(last_moment_error / moment_error, 4, 0.3);
    }
    last_volume_error = volume_error;
    last_moment_error = moment_error;
  }
  EXPECT_LT(last_volume_error, 0.003 * volume);
}

TEST(MassProperties, OfAFinerTorusComeCloserToTheTorus) {
  const double ring = 0.7;
  const double tube = 0.2;
  const double volume = 2 * kPi * kPi * ring * tube * tube;
  const double about_axis = volume * (ring * ring + 0.75 * tube * tube);
  const double across = volume * (0.5 * ring * ring + 0.625 * tube * tube);
  double last_error = 1;
  for (const int n : {16, 32, 64, 128}) {
    const MassProperties mass = mass_of(torus_mesh(ring, tube, 2 * n, n));
    const double error =
        std::max({std::abs(mass.volume_m3 / volume - 1), std::abs(mass.inertia_m5(2, 2) / about_axis - 1),
                  std::abs(mass.inertia_m5(0, 0) / across - 1)});
    EXPECT_LT(error, 0.3 * last_error);
    last_error = error;
  }
  EXPECT_LT(last_error, 2e-3);
}

RC_GTEST_PROP(MassProperties, FollowAMeshThatIsMovedTurnedAndScaled, ()) {
  const auto share = [](int low, int high) { return *rc::gen::inRange(low * 1000, high * 1000) / 1000.0; };
  const Vec3 axis(share(-1, 1), share(-1, 1), share(-1, 1));
  RC_PRE(axis.norm() > 0.1);
  const Mat3 turn = Eigen::AngleAxisd(share(-3, 3), axis.normalized()).toRotationMatrix();
  const double factor = share(1, 50);
  const Vec3 shift(share(-100, 100), share(-100, 100), share(-100, 100));
  const TriangleMesh mesh = geometry::make_procedural_shape("l").value();
  const MassProperties before = mesh_mass_properties(mesh).value();
  const MassProperties after = mesh_mass_properties(test::moved(mesh, factor, turn, shift)).value();
  const double cube = factor * factor * factor;
  // The vertices themselves are rounded at |shift|, so errors are relative to that.
  const double rounding = 1e-12 * (1 + shift.norm() / factor);
  RC_ASSERT(std::abs(after.volume_m3 - cube * before.volume_m3) <= rounding * cube * before.volume_m3);
  RC_ASSERT((after.center_of_mass_m - (turn * (factor * before.center_of_mass_m) + shift)).norm() <= rounding * factor);
  const Mat3 expected = cube * factor * factor * (turn * before.inertia_m5 * turn.transpose());
  RC_ASSERT((after.inertia_m5 - expected).norm() <= rounding * expected.norm());
}

TEST(MassProperties, KeepTheirDigitsAThousandDiagonalsFromTheOrigin) {
  const Vec3 size(1, 2, 3);
  const TriangleMesh far = test::moved(box_mesh(size), 1, Mat3::Identity(), {4096, -8192, 2048});
  EXPECT_LT((mass_of(far).inertia_m5 - box_inertia(size)).norm(), 1e-13 * box_inertia(size).norm());
}

TEST(MassProperties, RefuseAnOpenMeshWithTheCountOfItsOpenEdges) {
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  mesh.triangles.pop_back();
  const auto mass = mesh_mass_properties(mesh);
  ASSERT_FALSE(mass.ok());
  EXPECT_NE(mass.error().message.find("3 open edges"), std::string::npos) << mass.error().message;
}

TEST(MassProperties, RefuseAMeshWithoutVolume) {
  TriangleMesh flat;
  flat.vertices_m = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  const auto mass = mesh_mass_properties(flat);
  ASSERT_FALSE(mass.ok());
  EXPECT_NE(mass.error().message.find("must be > 0"), std::string::npos) << mass.error().message;
}

TEST(MassProperties, RefuseAMeshTurnedInsideOut) {
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_FALSE(mesh_mass_properties(mesh).ok());
}

TEST(MassProperties, RefuseNumbersThatAreNotFiniteAndTrianglesWithoutVertices) {
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  mesh.vertices_m[3].y() = std::nan("");
  EXPECT_NE(mesh_mass_properties(mesh).error().message.find("not finite"), std::string::npos);
  mesh = box_mesh(Vec3::Ones());
  mesh.triangles[5][1] = 8;
  EXPECT_NE(mesh_mass_properties(mesh).error().message.find("vertex 8 of 8"), std::string::npos);
  EXPECT_NE(mesh_mass_properties({}).error().message.find("no triangle"), std::string::npos);
}

}  // namespace
}  // namespace poise
