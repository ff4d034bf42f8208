// SPDX-License-Identifier: MIT
#include "accuracy/small_world.h"

#include <cmath>

namespace poise::accuracy {

std::uint64_t Random::bits() {
  state_ += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

double Random::unit() { return static_cast<double>(bits() >> 11U) * 0x1.0p-53; }

Vec3 Random::in_box(double half_m) {
  const double x = between(-half_m, half_m);
  const double y = between(-half_m, half_m);
  return {x, y, between(-half_m, half_m)};
}

Vec3 Random::direction() {
  for (;;) {
    const Vec3 v = in_box(1);
    const double length = v.norm();
    if (length > 0.1 && length <= 1) return v / length;
  }
}

Quat Random::turn() {
  for (;;) {
    const Vec3 v = in_box(1);
    const Quat q(between(-1, 1), v.x(), v.y(), v.z());
    if (q.norm() > 0.1 && q.norm() <= 1) return q.normalized();
  }
}

TriangleMesh box_mesh(const Vec3& size_m) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices_m.emplace_back(0.5 * size_m.x() * (i % 2 == 0 ? -1 : 1), 0.5 * size_m.y() * (i / 2 % 2 == 0 ? -1 : 1),
                                 0.5 * size_m.z() * (i / 4 == 0 ? -1 : 1));
  }
  // Bottom, top, and the four sides, each seen from outside.
  constexpr std::uint32_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

World SmallWorld::make(const Context& context, const Vec3& gravity_mps2) {
  WorldSettings settings = context.world_settings();
  settings.gravity_mps2 = gravity_mps2;
  return World::create(settings).value();
}

SmallWorld::SmallWorld(const Context& context, const Vec3& gravity_mps2, const Material& material)
    : world_(make(context, gravity_mps2)), material_(world_.add_material(material).value()) {}

ShapeId SmallWorld::box(const Vec3& size_m) {
  TreeBuildOptions options;
  options.depth = 2;
  options.preset = TreePreset::Fast;
  options.threads = 1;
  return shape(make_mesh_shape(box_mesh(size_m), options).value());
}

ShapeId SmallWorld::slab_of_balls(double half_m, double radius_m) {
  std::vector<Sphere> spheres;
  for (const double x : {-half_m, half_m}) {
    for (const double y : {-half_m, half_m}) spheres.push_back({Vec3(x, y, 0), radius_m});
  }
  return shape(make_spheres_shape(spheres).value());
}

ShapeId SmallWorld::jack() {
  std::vector<Sphere> spheres = {{Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      spheres.push_back({side * 0.35 * Vec3::Unit(axis), 0.22});
      spheres.push_back({side * 0.68 * Vec3::Unit(axis), 0.18});
    }
  }
  return shape(make_spheres_shape(spheres).value());
}

BodyId SmallWorld::add(BodyDefinition definition) {
  definition.material = material_;
  const Result<BodyId> id = world_.add_body(definition);
  if (!id) {
    ++refusals_;
    return {};
  }
  if (definition.motion == MotionType::Dynamic) bodies_.push_back(id.value());
  return id.value();
}

BodyId SmallWorld::add(ShapeId shape, const Vec3& position_m, const Vec3& velocity_mps, const Quat& orientation,
                       const Vec3& spin_radps, double mass_kg) {
  BodyDefinition body;
  body.shape = shape;
  body.position_m = position_m;
  body.velocity_mps = velocity_mps;
  body.orientation = orientation;
  body.angular_velocity_radps = spin_radps;
  body.mass_kg = mass_kg;
  return add(body);
}

BodyId SmallWorld::plane(const Vec3& normal, double offset_m) {
  BodyDefinition body;
  body.shape = shape(make_plane_shape(normal, offset_m).value());
  body.motion = MotionType::Static;
  return add(body);
}

void SmallWorld::closed_box(double half_m) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) plane(side * Vec3::Unit(axis), -half_m);
  }
}

void SmallWorld::tray(double side_m) {
  plane(Vec3::UnitZ(), 0);
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) plane(side * Vec3::Unit(axis), -0.5 * side_m);
  }
}

FrameReport SmallWorld::step(double dt_s) {
  input.dt_s = dt_s;
  return world_.step(input);
}

BodyState SmallWorld::at(BodyId body) const {
  const Result<BodyState> state = world_.state(body);
  if (state) return state.value();
  BodyState none;
  none.position_m.setConstant(std::nan(""));
  return none;
}

double SmallWorld::energy_j() const {
  const Conserved c = world_.conserved();
  return c.kinetic_j + c.potential_j;
}

MomentumScale SmallWorld::momentum_scale() const { return motions_of(world_, bodies_).scale; }

double BodyMotion::kinetic_j() const {
  return 0.5 * mass_kg * state.velocity_mps.squaredNorm() +
         0.5 * state.angular_velocity_radps.dot(inertia_kgm2 * state.angular_velocity_radps);
}

Vec3 BodyMotion::angular_momentum_js() const {
  return mass_kg * state.position_m.cross(state.velocity_mps) + inertia_kgm2 * state.angular_velocity_radps;
}

BodyMotion motion_of(const World& world, BodyId body) {
  BodyMotion motion;
  motion.mass_kg = world.mass_kg(body).value();
  motion.state = world.state(body).value();
  const ShapePtr shape = world.shape(body).value();
  const Mat3 turn = (motion.state.orientation * shape->principal_axes).toRotationMatrix();
  motion.inertia_kgm2 = motion.mass_kg / shape->volume_m3 * turn * shape->principal_m5.asDiagonal() * turn.transpose();
  return motion;
}

Motions motions_of(const World& world, const std::vector<BodyId>& bodies) {
  Motions sums;
  for (const BodyId body : bodies) {
    const BodyMotion motion = motion_of(world, body);
    sums.kinetic_j += motion.kinetic_j();
    sums.momentum_ns += motion.momentum_ns();
    sums.angular_momentum_js += motion.angular_momentum_js();
    sums.scale.momentum_ns += motion.momentum_ns().norm();
    sums.scale.angular_momentum_js += motion.angular_momentum_js().norm();
  }
  return sums;
}

}  // namespace poise::accuracy
