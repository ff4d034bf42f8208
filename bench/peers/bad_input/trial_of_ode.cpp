// SPDX-License-Identifier: MIT
#include <ode/ode.h>

#include <array>
#include <memory>

#include "bad_input/box_mesh.h"
#include "bad_input/trial.h"

namespace poise::bench {
namespace {

/// Objects are never freed: the program ends after one trial.
struct OdeTrial {
  dWorldID world = dWorldCreate();
  dSpaceID space = dHashSpaceCreate(nullptr);
  dJointGroupID contacts = dJointGroupCreate(0);
  std::vector<dBodyID> bodies;
  // The library keeps pointers into these.
  std::array<double, 24> vertices{};
  std::array<dTriIndex, 36> indices{};

  dGeomID mesh(const std::array<Vec3, 8>& corners, bool inside_out) {
    for (std::size_t i = 0; i < 24; ++i) vertices[i] = corners[i / 3][static_cast<Eigen::Index>(i % 3)];
    for (std::size_t i = 0; i < 12; ++i) {
      const auto& [a, b, c] = kBoxTriangles[i];
      indices[3 * i] = a;
      indices[3 * i + 1] = inside_out ? c : b;
      indices[3 * i + 2] = inside_out ? b : c;
    }
    const dTriMeshDataID data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(data, vertices.data(), 3 * sizeof(double), 8, indices.data(), 36,
                                3 * sizeof(dTriIndex));
    return dCreateTriMesh(space, data, nullptr, nullptr, nullptr);
  }
  void add(dGeomID geom, const dMass& mass, const Vec3& position_m, const Quat& q) {
    const dBodyID body = dBodyCreate(world);
    dBodySetMass(body, &mass);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, position_m.x(), position_m.y(), position_m.z());
    const dQuaternion turn = {q.w(), q.x(), q.y(), q.z()};
    dBodySetQuaternion(body, turn);
    bodies.push_back(body);
  }
  static void near(void* data, dGeomID a, dGeomID b) {
    const auto& trial = *static_cast<const OdeTrial*>(data);
    std::array<dContact, 8> found{};
    const int count = dCollide(a, b, 8, &found[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      dContact& contact = found[static_cast<std::size_t>(i)];
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = 0.5;
      dJointAttach(dJointCreateContact(trial.world, trial.contacts, &contact), dGeomGetBody(a), dGeomGetBody(b));
    }
  }
};

}  // namespace

TrialEngine trial_of_ode(Ground ground) {
  dInitODE2(0);
  dAllocateODEDataForThread(static_cast<unsigned int>(dAllocateMaskAll));
  const auto trial = std::make_shared<OdeTrial>();
  dWorldSetGravity(trial->world, 0, 0, -9.81);
  if (ground == Ground::Plane) {
    dCreatePlane(trial->space, 0, 0, 1, 0);
  } else {
    trial->mesh(box_corners(Vec3(4, 4, 1), Vec3(0, 0, -1)), true);
  }
  TrialEngine engine;
  engine.version = "ODE 0.16.2, double precision";
  engine.add = [trial](const TrialBody& body) -> Status {
    dMass mass;
    if (body.box) {
      dMassSetBoxTotal(&mass, body.mass_kg, 0.5, 0.5, 0.5);
    } else {
      dMassSetSphereTotal(&mass, body.mass_kg, 0.25);
    }
    trial->add(body.box ? dCreateBox(trial->space, 0.5, 0.5, 0.5) : dCreateSphere(trial->space, 0.25), mass,
               body.position_m, body.orientation);
    return Done{};
  };
  engine.add_degenerate = [trial]() -> Status {
    std::array<Vec3, 8> same;
    same.fill(Vec3::Zero());
    const dGeomID geom = trial->mesh(same, false);
    dMass mass;
    dMassSetTrimeshTotal(&mass, 1, geom);
    trial->add(geom, mass, Vec3(0, 0, 2), Quat::Identity());
    return Done{};
  };
  engine.set_velocity = [trial](std::size_t body, const Vec3& v) -> Status {
    dBodySetLinearVel(trial->bodies[body], v.x(), v.y(), v.z());
    return Done{};
  };
  engine.step = [trial](double dt_s) -> Status {
    dSpaceCollide(trial->space, trial.get(), &OdeTrial::near);
    dWorldQuickStep(trial->world, dt_s);
    dJointGroupEmpty(trial->contacts);
    return Done{};
  };
  engine.positions_m = [trial] {
    std::vector<Vec3> positions;
    for (const dBodyID body : trial->bodies) positions.emplace_back(Vec3::Map(dBodyGetPosition(body)));
    return positions;
  };
  return engine;
}

}  // namespace poise::bench
