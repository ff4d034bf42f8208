// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "accuracy/accuracy_case.h"
#include "poise/mesh.h"
#include "poise/shape.h"
#include "poise/world.h"

namespace poise::accuracy {

inline constexpr double kGravityMps2 = 9.81;

/// Random numbers for all cases: SplitMix64 (Steele, Lea and Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits();
  double unit();  ///< uniform in [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }
  Vec3 in_box(double half_m);  ///< uniform in the cube of this half side
  Vec3 direction();            ///< uniform over the sphere, by rejection
  Quat turn();                 ///< uniform over all rotations, by rejection

 private:
  std::uint64_t state_;
};

/// The largest possible |p| and |L| of a set of bodies; errors of momentum are given as shares of these.
struct MomentumScale {
  double momentum_ns = 0, angular_momentum_js = 0;
};

/// A World of one case with short functions to fill it. If the World refuses a body, the body is omitted and counted,
/// so that the case reports it as a row instead of ending the study.
class SmallWorld {
 public:
  SmallWorld(const Context& context, const Vec3& gravity_mps2, const Material& material);

  ShapeId shape(const ShapePtr& shape) { return world_.add_shape(shape); }
  ShapeId ball(double radius_m) { return shape(make_sphere_shape(radius_m).value()); }
  ShapeId box(const Vec3& size_m);                        ///< a mesh of 12 triangles
  ShapeId slab_of_balls(double half_m, double radius_m);  ///< four balls at the corners of a square
  ShapeId jack();                                         ///< three crossed rods of 13 balls, 1.72 m across
  /// Adds a body with the World's material; the other fields are used as given.
  BodyId add(BodyDefinition definition);
  BodyId add(ShapeId shape, const Vec3& position_m, const Vec3& velocity_mps = Vec3::Zero(),
             const Quat& orientation = Quat::Identity(), const Vec3& spin_radps = Vec3::Zero(), double mass_kg = 0);
  BodyId plane(const Vec3& normal, double offset_m);
  void closed_box(double half_m);  ///< six planes around the origin
  void tray(double side_m);        ///< a floor and four walls

  StepInput input;  ///< of the next steps
  FrameReport step(double dt_s);
  [[nodiscard]] BodyState at(BodyId body) const;
  [[nodiscard]] double energy_j() const;
  [[nodiscard]] Conserved sums() const { return world_.conserved(); }
  [[nodiscard]] MomentumScale momentum_scale() const;
  World& world() { return world_; }
  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] const std::vector<BodyId>& bodies() const { return bodies_; }  ///< dynamic ones, in order
  [[nodiscard]] int refusals() const { return refusals_; }

 private:
  static World make(const Context& context, const Vec3& gravity_mps2);
  World world_;
  MaterialId material_;
  std::vector<BodyId> bodies_;
  int refusals_ = 0;
};

/// A box around the origin as 12 triangles.
TriangleMesh box_mesh(const Vec3& size_m);

/// Energy and momenta of one body of mass m (kg) and inertia about its centre (kg m^2, world frame), computed here and
/// not by the engine.
struct BodyMotion {
  double mass_kg = 0;
  Mat3 inertia_kgm2 = Mat3::Zero();
  BodyState state;
  [[nodiscard]] double kinetic_j() const;
  [[nodiscard]] Vec3 momentum_ns() const { return mass_kg * state.velocity_mps; }
  [[nodiscard]] Vec3 angular_momentum_js() const;
};
/// For a dynamic body with the inertia of its shape at uniform density.
BodyMotion motion_of(const World& world, BodyId body);

/// Sums over all of these bodies.
struct Motions {
  double kinetic_j = 0;
  Vec3 momentum_ns = Vec3::Zero(), angular_momentum_js = Vec3::Zero();
  MomentumScale scale;
};
Motions motions_of(const World& world, const std::vector<BodyId>& bodies);

}  // namespace poise::accuracy
