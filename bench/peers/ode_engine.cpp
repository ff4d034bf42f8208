// SPDX-License-Identifier: MIT
#include <ode/ode.h>

#include <array>
#include <memory>
#include <vector>

#include "peers/fresh_pile.h"

namespace poise::bench {
namespace {

/// The library is initialised while an object of this class exists. Invariant: the destructor of the last one closes
/// it.
class OdeLibrary {
 public:
  static std::shared_ptr<OdeLibrary> open() {
    static std::weak_ptr<OdeLibrary> opened;
    std::shared_ptr<OdeLibrary> library = opened.lock();
    if (!library) opened = library = std::make_shared<OdeLibrary>();
    return library;
  }
  OdeLibrary() {
    dInitODE2(0);
    dAllocateODEDataForThread(static_cast<unsigned int>(dAllocateMaskAll));
  }
  ~OdeLibrary() { dCloseODE(); }
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;
};

/// Invariant: owns its world, space and contacts. Flat: all spheres are in one space.
template <bool kFlat>
class OdePile {
 public:
  explicit OdePile(const PileScene& scene)
      : library_(OdeLibrary::open()),
        world_(dWorldCreate()),
        space_(dHashSpaceCreate(nullptr)),
        contacts_(dJointGroupCreate(0)),
        friction_(scene.friction),
        restitution_(scene.restitution),
        dt_s_(scene.dt_s) {
    dWorldSetGravity(world_, scene.gravity_mps2.x(), scene.gravity_mps2.y(), scene.gravity_mps2.z());
    for (const PileScene::Wall& wall : scene.walls) {
      dCreatePlane(space_, wall.normal.x(), wall.normal.y(), wall.normal.z(), wall.offset_m);
    }
    for (const BodyState& start : scene.start) add(start, scene);
    dRandSetSeed(0);  // QuickStep draws the order of its rows
  }
  ~OdePile() {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }
  OdePile(const OdePile&) = delete;
  OdePile& operator=(const OdePile&) = delete;

  void iterations(int count) { dWorldSetQuickStepNumIterations(world_, count); }

  void step() {
    dSpaceCollide(space_, this, &near_callback);
    dWorldQuickStep(world_, dt_s_);
    dJointGroupEmpty(contacts_);
  }

  void read(std::span<BodyState> states) const {
    for (std::size_t i = 0; i < states.size(); ++i) {
      const dReal* const turn = dBodyGetQuaternion(bodies_[i]);
      states[i].position_m = Vec3::Map(dBodyGetPosition(bodies_[i]));
      states[i].orientation = Quat(turn[0], turn[1], turn[2], turn[3]);
      states[i].velocity_mps = Vec3::Map(dBodyGetLinearVel(bodies_[i]));
      states[i].angular_velocity_radps = Vec3::Map(dBodyGetAngularVel(bodies_[i]));
    }
  }

 private:
  static void place(dBodyID body, const BodyState& state) {
    const Quat& turn = state.orientation;
    const dQuaternion q = {turn.w(), turn.x(), turn.y(), turn.z()};
    dBodySetPosition(body, state.position_m.x(), state.position_m.y(), state.position_m.z());
    dBodySetQuaternion(body, q);
    dBodySetLinearVel(body, state.velocity_mps.x(), state.velocity_mps.y(), state.velocity_mps.z());
    dBodySetAngularVel(body, state.angular_velocity_radps.x(), state.angular_velocity_radps.y(),
                       state.angular_velocity_radps.z());
  }
  void add(const BodyState& start, const PileScene& scene) {
    const dBodyID body = dBodyCreate(world_);
    bodies_.push_back(body);
    dMass mass;
    dMassSetParameters(&mass, scene.mass_kg, 0, 0, 0, scene.inertia_kgm2.x(), scene.inertia_kgm2.y(),
                       scene.inertia_kgm2.z(), 0, 0, 0);
    dBodySetMass(body, &mass);
    place(body, start);
    const dSpaceID own = kFlat ? space_ : dSimpleSpaceCreate(space_);
    for (const Sphere& sphere : scene.spheres) {
      const dGeomID geom = dCreateSphere(own, sphere.radius_m);
      dGeomSetBody(geom, body);
      dGeomSetOffsetPosition(geom, sphere.center_m.x(), sphere.center_m.y(), sphere.center_m.z());
    }
  }

  static void near_callback(void* data, dGeomID a, dGeomID b) {
    if (dGeomIsSpace(a) != 0 || dGeomIsSpace(b) != 0) {
      dSpaceCollide2(a, b, data, &near_callback);
      return;
    }
    const auto& pile = *static_cast<const OdePile*>(data);
    const dBodyID body_a = dGeomGetBody(a);
    const dBodyID body_b = dGeomGetBody(b);
    if (body_a == body_b) return;
    // Two spheres, or a sphere and a plane, have one contact point.
    dContact contact{};
    if (dCollide(a, b, 1, &contact.geom, sizeof(dContact)) == 0) return;
    contact.surface.mode = dContactApprox1 | dContactBounce;
    contact.surface.mu = pile.friction_;
    contact.surface.bounce = pile.restitution_;
    contact.surface.bounce_vel = kBounceFromMps;
    dJointAttach(dJointCreateContact(pile.world_, pile.contacts_, &contact), body_a, body_b);
  }

  std::shared_ptr<OdeLibrary> library_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  std::vector<dBodyID> bodies_;
  double friction_;
  double restitution_;
  double dt_s_;
};

}  // namespace

Engine make_ode(const PileScene& scene, bool flat) {
  static_assert(sizeof(dReal) == sizeof(double));
  Engine engine = flat ? engine_of<OdePile<true>>(scene) : engine_of<OdePile<false>>(scene);
  engine.name = flat ? "ode flat" : "ode";
  engine.version = "0.16, double";
  return engine;
}

}  // namespace poise::bench
