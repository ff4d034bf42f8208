// SPDX-License-Identifier: MIT
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <memory>
#include <vector>

#include "peers/fresh_pile.h"

namespace poise::bench {
namespace {

btVector3 to_bullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

Vec3 from_bullet(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

btTransform transform_of(const BodyState& state) {
  const Quat& turn = state.orientation;
  return btTransform(btQuaternion(static_cast<btScalar>(turn.x()), static_cast<btScalar>(turn.y()),
                                  static_cast<btScalar>(turn.z()), static_cast<btScalar>(turn.w())),
                     to_bullet(state.position_m));
}

/// A world and the objects that it refers to. Invariant: it refers to nothing else, and is destroyed first.
class BulletPile {
 public:
  explicit BulletPile(const PileScene& scene)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broad_phase_, &solver_, &configuration_),
        dt_s_(static_cast<btScalar>(scene.dt_s)) {
    world_.setGravity(to_bullet(scene.gravity_mps2));
    for (const Sphere& sphere : scene.spheres) {
      spheres_.push_back(std::make_unique<btSphereShape>(static_cast<btScalar>(sphere.radius_m)));
      const btTransform place(btQuaternion::getIdentity(), to_bullet(sphere.center_m));
      compound_.addChildShape(place, spheres_.back().get());
    }
    for (const PileScene::Wall& wall : scene.walls) {
      planes_.push_back(
          std::make_unique<btStaticPlaneShape>(to_bullet(wall.normal), static_cast<btScalar>(wall.offset_m)));
      add({0, nullptr, planes_.back().get()}, scene);
    }
    first_body_ = bodies_.size();
    for (const BodyState& start : scene.start) add_body(start, scene);
  }
  BulletPile(const BulletPile&) = delete;
  BulletPile& operator=(const BulletPile&) = delete;
  ~BulletPile() {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  void iterations(int count) { world_.getSolverInfo().m_numIterations = count; }

  // Without Bullet's own substeps: one step of dt.
  void step() { world_.stepSimulation(dt_s_, 0); }

  void read(std::span<BodyState> states) const {
    for (std::size_t i = 0; i < states.size(); ++i) {
      const btRigidBody& body = *bodies_[first_body_ + i];
      const btQuaternion turn = body.getCenterOfMassTransform().getRotation();
      states[i].position_m = from_bullet(body.getCenterOfMassPosition());
      const Vec3 axis = from_bullet({turn.x(), turn.y(), turn.z()});
      states[i].orientation = Quat(static_cast<double>(turn.w()), axis.x(), axis.y(), axis.z()).normalized();
      states[i].velocity_mps = from_bullet(body.getLinearVelocity());
      states[i].angular_velocity_radps = from_bullet(body.getAngularVelocity());
    }
  }

 private:
  void add(btRigidBody::btRigidBodyConstructionInfo info, const PileScene& scene) {
    // Bullet multiplies the coefficients of both bodies.
    info.m_friction = static_cast<btScalar>(std::sqrt(scene.friction));
    info.m_restitution = static_cast<btScalar>(std::sqrt(scene.restitution));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_.addRigidBody(bodies_.back().get());
  }
  void add_body(const BodyState& start, const PileScene& scene) {
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(scene.mass_kg), nullptr, &compound_,
                                                  to_bullet(scene.inertia_kgm2));
    info.m_startWorldTransform = transform_of(start);
    add(info, scene);
    bodies_.back()->setLinearVelocity(to_bullet(start.velocity_mps));
    bodies_.back()->setAngularVelocity(to_bullet(start.angular_velocity_radps));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
  }

  std::vector<std::unique_ptr<btSphereShape>> spheres_;
  std::vector<std::unique_ptr<btStaticPlaneShape>> planes_;
  btCompoundShape compound_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broad_phase_;
  btSequentialImpulseConstraintSolver solver_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  btDiscreteDynamicsWorld world_;
  std::size_t first_body_ = 0;
  btScalar dt_s_;
};

}  // namespace

Engine make_bullet(const PileScene& scene) {
  Engine engine = engine_of<BulletPile>(scene);
  engine.name = "bullet";
  const int version = btGetVersion();
  engine.version = std::to_string(version / 100) + "." + std::to_string(version % 100) +
                   (sizeof(btScalar) == sizeof(double) ? ", double" : ", single");
  return engine;
}

}  // namespace poise::bench
