// SPDX-License-Identifier: MIT
#include "dynamics/body_store.h"

#include <algorithm>
#include <functional>

#include "poise_assert.h"

namespace poise::dynamics {

BodyId BodyStore::add() {
  std::uint32_t slot = 0;
  if (free_.empty()) {
    slot = static_cast<std::uint32_t>(alive.size());
    for (auto* column :
         {&x_m,      &y_m,      &z_m,  &qx,   &qy,   &qz,    &vx_mps, &vy_mps, &vz_mps,  &wx_radps,
          &wy_radps, &wz_radps, &fx_n, &fy_n, &fz_n, &tx_nm, &ty_nm,  &tz_nm,  &mass_kg, &inverse_mass}) {
      column->push_back(0);
    }
    qw.push_back(1);
    principal_kgm2.emplace_back(Vec3::Zero());
    shape.emplace_back();
    material.push_back(0);
    group.push_back(1);
    collides_with.push_back(0xffffffffU);
    importance.push_back(1);
    user_data.push_back(0);
    generation.push_back(0);
    alive.push_back(1);
    dynamic.push_back(0);
    asleep.push_back(0);
    paused.push_back(0);
    kinematic.push_back(0);
    pushed.push_back(0);
    frames_held.push_back(0);
    changed.push_back(1);
  } else {
    std::pop_heap(free_.begin(), free_.end(), std::greater<>());
    slot = free_.back();
    free_.pop_back();
    alive[slot] = 1;
    changed[slot] = 1;
  }
  ++alive_count_;
  return id_of(slot);
}

void BodyStore::remove(std::uint32_t slot) {
  POISE_ASSERT(slot < alive.size() && alive[slot] != 0);
  if (dynamic[slot] != 0) --dynamic_count_;
  if (asleep[slot] != 0) --asleep_count_;
  if (paused[slot] != 0) --paused_count_;
  if (kinematic[slot] != 0) --kinematic_count_;
  --alive_count_;
  alive[slot] = 0;
  dynamic[slot] = 0;
  kinematic[slot] = 0;
  asleep[slot] = 0;
  paused[slot] = 0;
  pushed[slot] = 0;
  frames_held[slot] = 0;
  ++generation[slot];
  mass_kg[slot] = 0;
  inverse_mass[slot] = 0;
  principal_kgm2[slot].setZero();
  shape[slot].reset();
  set_velocity(slot, Vec3::Zero());
  set_spin(slot, Vec3::Zero());
  set_force(slot, Vec3::Zero());
  set_torque(slot, Vec3::Zero());
  free_.push_back(slot);
  std::push_heap(free_.begin(), free_.end(), std::greater<>());
}

void BodyStore::make_dynamic(std::uint32_t slot) {
  POISE_ASSERT(alive[slot] != 0 && dynamic[slot] == 0);
  dynamic[slot] = 1;
  changed[slot] = 1;
  ++dynamic_count_;
}

void BodyStore::make_kinematic(std::uint32_t slot) {
  POISE_ASSERT(alive[slot] != 0 && dynamic[slot] == 0 && kinematic[slot] == 0);
  kinematic[slot] = 1;
  changed[slot] = 1;
  ++kinematic_count_;
}

void BodyStore::put_to_sleep(std::uint32_t slot) {
  stop(slot);
  set_velocity(slot, Vec3::Zero());
  set_spin(slot, Vec3::Zero());
}

void BodyStore::pause(std::uint32_t slot) {
  stop(slot);
  paused[slot] = 1;
  ++paused_count_;
}

void BodyStore::stop(std::uint32_t slot) {
  POISE_ASSERT(dynamic[slot] != 0 && pushed[slot] == 0);
  dynamic[slot] = 0;
  asleep[slot] = 1;
  changed[slot] = 1;
  inverse_mass[slot] = 0;
  --dynamic_count_;
  ++asleep_count_;
}

void BodyStore::wake(std::uint32_t slot) { count_woken(1, begin_wake(slot) ? 1 : 0); }

bool BodyStore::begin_wake(std::uint32_t slot) {
  POISE_ASSERT(asleep[slot] != 0);
  const bool waited = paused[slot] != 0;
  paused[slot] = 0;
  dynamic[slot] = 1;
  asleep[slot] = 0;
  changed[slot] = 1;
  inverse_mass[slot] = 1.0 / mass_kg[slot];
  return waited;
}

void BodyStore::count_woken(std::size_t bodies, std::size_t of_paused) {
  dynamic_count_ += bodies;
  asleep_count_ -= bodies;
  paused_count_ -= of_paused;
}

void BodyStore::exchange(BodyStates& states) noexcept {
  for (std::size_t k = 0; k < BodyStates::kColumns; ++k) (this->*kColumnsOfState[k]).swap(states.columns[k]);
  dynamic.swap(states.dynamic);
  asleep.swap(states.asleep);
  paused.swap(states.paused);
  std::swap(dynamic_count_, states.dynamic_count);
  std::swap(asleep_count_, states.asleep_count);
  std::swap(paused_count_, states.paused_count);
}

void BodyStore::set_position(std::size_t i, const Vec3& p) {
  changed[i] = 1;
  x_m[i] = p.x();
  y_m[i] = p.y();
  z_m[i] = p.z();
}

void BodyStore::set_orientation(std::size_t i, const Quat& q) {
  changed[i] = 1;
  qw[i] = q.w();
  qx[i] = q.x();
  qy[i] = q.y();
  qz[i] = q.z();
}

void BodyStore::set_velocity(std::size_t i, const Vec3& v) {
  changed[i] = 1;
  vx_mps[i] = v.x();
  vy_mps[i] = v.y();
  vz_mps[i] = v.z();
}

void BodyStore::set_spin(std::size_t i, const Vec3& w) {
  changed[i] = 1;
  wx_radps[i] = w.x();
  wy_radps[i] = w.y();
  wz_radps[i] = w.z();
}

void BodyStore::set_force(std::size_t i, const Vec3& f) {
  fx_n[i] = f.x();
  fy_n[i] = f.y();
  fz_n[i] = f.z();
}

void BodyStore::set_torque(std::size_t i, const Vec3& t) {
  tx_nm[i] = t.x();
  ty_nm[i] = t.y();
  tz_nm[i] = t.z();
}

Quat principal_to_world(const BodyStore& bodies, std::size_t i) {
  return bodies.orientation(i) * bodies.shape[i]->principal_axes;
}

Mat3 inertia_world(const BodyStore& bodies, std::size_t i) {
  if (bodies.dynamic[i] == 0) return Mat3::Zero();
  const Mat3 turn = principal_to_world(bodies, i).toRotationMatrix();
  return turn * bodies.principal_kgm2[i].asDiagonal() * turn.transpose();
}

Mat3 inverse_inertia_world(const BodyStore& bodies, std::size_t i) {
  if (bodies.dynamic[i] == 0) return Mat3::Zero();
  const Vec3& moments = bodies.principal_kgm2[i];
  if (moments.x() == moments.y() && moments.y() == moments.z()) return Mat3::Identity() / moments.x();
  const Mat3 turn = principal_to_world(bodies, i).toRotationMatrix();
  return turn * moments.cwiseInverse().asDiagonal() * turn.transpose();
}

}  // namespace poise::dynamics
