// SPDX-License-Identifier: MIT
#include <btBulletDynamicsCommon.h>

#include <memory>

#include "bad_input/box_mesh.h"
#include "bad_input/trial.h"

namespace poise::bench {
namespace {

btVector3 to_bullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

/// Objects are never freed: the program ends after one trial.
struct BulletTrial {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broad_phase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broad_phase, &solver, &configuration};
  btTriangleMesh triangles;
  std::vector<btRigidBody*> bodies;

  btRigidBody* add(btCollisionShape* shape, double mass_kg, const Vec3& position_m, const Quat& q) {
    btVector3 inertia(0, 0, 0);
    if (mass_kg != 0) shape->calculateLocalInertia(static_cast<btScalar>(mass_kg), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass_kg), nullptr, shape, inertia);
    info.m_startWorldTransform = btTransform(btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                                                          static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w())),
                                             to_bullet(position_m));
    auto* body = new btRigidBody(info);
    body->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(body);
    return body;
  }
};

}  // namespace

TrialEngine trial_of_bullet(Ground ground) {
  const auto trial = std::make_shared<BulletTrial>();
  trial->world.setGravity({0, 0, btScalar(-9.81)});
  if (ground == Ground::Plane) {
    trial->add(new btStaticPlaneShape({0, 0, 1}, 0), 0, Vec3::Zero(), Quat::Identity());
  } else {
    const std::array<Vec3, 8> corners = box_corners(Vec3(4, 4, 1), Vec3(0, 0, -1));
    for (const auto& [a, b, c] : kBoxTriangles)
      trial->triangles.addTriangle(to_bullet(corners[a]), to_bullet(corners[c]), to_bullet(corners[b]));
    trial->add(new btBvhTriangleMeshShape(&trial->triangles, true), 0, Vec3::Zero(), Quat::Identity());
  }
  TrialEngine engine;
  engine.version = "Bullet 3.24, single precision";
  engine.add = [trial](const TrialBody& body) -> Status {
    btCollisionShape* shape = new btSphereShape(btScalar(0.25));
    if (body.box) shape = new btBoxShape({btScalar(0.25), btScalar(0.25), btScalar(0.25)});
    trial->bodies.push_back(trial->add(shape, body.mass_kg, body.position_m, body.orientation));
    return Done{};
  };
  engine.add_degenerate = [trial]() -> Status {
    auto* hull = new btConvexHullShape();
    for (int i = 0; i < 8; ++i) hull->addPoint({0, 0, 0});
    trial->bodies.push_back(trial->add(hull, 1, Vec3(0, 0, 2), Quat::Identity()));
    return Done{};
  };
  engine.set_velocity = [trial](std::size_t body, const Vec3& velocity_mps) -> Status {
    trial->bodies[body]->setLinearVelocity(to_bullet(velocity_mps));
    return Done{};
  };
  engine.step = [trial](double dt_s) -> Status {
    trial->world.stepSimulation(static_cast<btScalar>(dt_s), 0);
    return Done{};
  };
  engine.positions_m = [trial] {
    std::vector<Vec3> positions;
    for (const btRigidBody* body : trial->bodies) {
      const btVector3 at = body->getCenterOfMassPosition();
      positions.emplace_back(static_cast<double>(at.x()), static_cast<double>(at.y()), static_cast<double>(at.z()));
    }
    return positions;
  };
  return engine;
}

}  // namespace poise::bench
