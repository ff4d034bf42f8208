// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "poise/shape.h"
#include "poise/types.h"

namespace poise::dynamics {

/// What a step changes of bodies that callers see: one entry a slot each.
struct BodyStates {
  static constexpr std::size_t kColumns = 19;
  std::array<std::vector<double>, kColumns> columns;  ///< BodyStore::kColumnsOfState
  std::vector<std::uint8_t> dynamic, asleep, paused;
  std::size_t dynamic_count = 0, asleep_count = 0, paused_count = 0;
};

/// The bodies of a World as structure of arrays, one entry a slot, double precision, SI units, world frame. Invariant:
/// all arrays have slot_count() entries; a dead slot has zero velocity and zero inverse mass; all numbers are finite. A
/// reused slot gets the next generation.
///
/// Positions are those of the centre of mass; orientations rotate the body frame (axes of the mesh) into the world.
struct BodyStore {
  std::vector<double> x_m, y_m, z_m;
  std::vector<double> qw, qx, qy, qz;
  std::vector<double> vx_mps, vy_mps, vz_mps;
  std::vector<double> wx_radps, wy_radps, wz_radps;
  std::vector<double> fx_n, fy_n, fz_n;       ///< applied for the next step
  std::vector<double> tx_nm, ty_nm, tz_nm;    ///< applied for the next step, about the centre of mass
  std::vector<double> mass_kg, inverse_mass;  ///< 0 for static and kinematic bodies; of sleeping bodies only the
                                              ///< inverse is 0
  std::vector<Vec3> principal_kgm2;           ///< moments in the principal frame; 0 for static bodies
  std::vector<ShapePtr> shape;
  std::vector<std::uint32_t> material;
  std::vector<std::uint32_t> group, collides_with;
  std::vector<double> importance;
  std::vector<std::uint64_t> user_data;  ///< the caller's value; not part of the state
  std::vector<std::uint32_t> generation;
  std::vector<std::uint8_t> alive;
  std::vector<std::uint8_t> dynamic;    ///< alive, neither static nor kinematic, and awake: forces and impulses move it
  std::vector<std::uint8_t> asleep;     ///< alive, neither static nor kinematic, and treated as static while it sleeps
  std::vector<std::uint8_t> paused;     ///< asleep, but only to wait: it keeps its velocity
  std::vector<std::uint8_t> kinematic;  ///< alive, and moved by its velocity alone
  std::vector<std::uint8_t> pushed;     ///< a force or torque is applied in the next step
  /// State, group or kind were set since the last step ended: what stages know of a body that does not move is out of
  /// date. Not part of the state.
  std::vector<std::uint8_t> changed;
  std::vector<std::uint8_t> frames_held;  ///< for how many frames the body has waited (frame/budget/hold.h)

  /// State, and the forces applied for the next step.
  static const std::array<std::vector<double> BodyStore::*, BodyStates::kColumns> kColumnsOfState;

  [[nodiscard]] std::size_t slot_count() const { return alive.size(); }
  [[nodiscard]] std::size_t alive_count() const { return alive_count_; }
  [[nodiscard]] std::size_t dynamic_count() const { return dynamic_count_; }  ///< awake ones
  [[nodiscard]] std::size_t asleep_count() const { return asleep_count_; }
  [[nodiscard]] std::size_t paused_count() const { return paused_count_; }  ///< of these, those that only wait
  [[nodiscard]] std::size_t kinematic_count() const { return kinematic_count_; }
  /// Kinematic with a velocity: such a body moves, although contacts treat its mass as infinite, as they do for static
  /// and sleeping bodies.
  [[nodiscard]] bool moves_by_itself(std::size_t i) const {
    return kinematic[i] != 0 && !(velocity(i).isZero(0) && spin(i).isZero(0));
  }

  /// Moves in a step, by forces or by its velocity.
  [[nodiscard]] bool moves(std::size_t i) const { return dynamic[i] != 0 || moves_by_itself(i); }

  /// Takes the lowest free slot, with all numbers zero and identity orientation.
  BodyId add();
  /// Frees the slot; its handle becomes stale.
  void remove(std::uint32_t slot);
  [[nodiscard]] bool contains(BodyId id) const {
    return id.slot < alive.size() && alive[id.slot] != 0 && generation[id.slot] == id.generation;
  }
  [[nodiscard]] BodyId id_of(std::uint32_t slot) const { return {slot, generation[slot]}; }
  void make_dynamic(std::uint32_t slot);
  void make_kinematic(std::uint32_t slot);
  /// A dynamic body stops and is treated as static until it wakes; its inverse mass is saved.
  void put_to_sleep(std::uint32_t slot);
  /// A dynamic body waits as if it slept, but keeps its velocity.
  void pause(std::uint32_t slot);
  /// A sleeping body becomes dynamic again, at rest unless it was paused.
  void wake(std::uint32_t slot);
  /// The parts of wake(): of one body, for different ones in any threads, which returns whether it only waited; and
  /// then the counts of all of them.
  bool begin_wake(std::uint32_t slot);
  void count_woken(std::size_t bodies, std::size_t of_paused);

  /// Exchanges them for those of another time, of the same bodies. In constant time.
  void exchange(BodyStates& states) noexcept;

  [[nodiscard]] Vec3 position(std::size_t i) const { return {x_m[i], y_m[i], z_m[i]}; }
  [[nodiscard]] Quat orientation(std::size_t i) const { return {qw[i], qx[i], qy[i], qz[i]}; }
  [[nodiscard]] Vec3 velocity(std::size_t i) const { return {vx_mps[i], vy_mps[i], vz_mps[i]}; }
  [[nodiscard]] Vec3 spin(std::size_t i) const { return {wx_radps[i], wy_radps[i], wz_radps[i]}; }
  [[nodiscard]] Vec3 force(std::size_t i) const { return {fx_n[i], fy_n[i], fz_n[i]}; }
  [[nodiscard]] Vec3 torque(std::size_t i) const { return {tx_nm[i], ty_nm[i], tz_nm[i]}; }
  void set_position(std::size_t i, const Vec3& p);
  void set_orientation(std::size_t i, const Quat& q);
  void set_velocity(std::size_t i, const Vec3& v);
  void set_spin(std::size_t i, const Vec3& w);
  void set_force(std::size_t i, const Vec3& f);
  void set_torque(std::size_t i, const Vec3& t);

 private:
  void stop(std::uint32_t slot);

  std::vector<std::uint32_t> free_;  // a heap whose front is the lowest free slot
  std::size_t alive_count_ = 0;
  std::size_t dynamic_count_ = 0;
  std::size_t asleep_count_ = 0;
  std::size_t paused_count_ = 0;
  std::size_t kinematic_count_ = 0;
};

inline constexpr std::array<std::vector<double> BodyStore::*, BodyStates::kColumns> BodyStore::kColumnsOfState = {
    &BodyStore::x_m,      &BodyStore::y_m,      &BodyStore::z_m,      &BodyStore::qw,     &BodyStore::qx,
    &BodyStore::qy,       &BodyStore::qz,       &BodyStore::vx_mps,   &BodyStore::vy_mps, &BodyStore::vz_mps,
    &BodyStore::wx_radps, &BodyStore::wy_radps, &BodyStore::wz_radps, &BodyStore::fx_n,   &BodyStore::fy_n,
    &BodyStore::fz_n,     &BodyStore::tx_nm,    &BodyStore::ty_nm,    &BodyStore::tz_nm};

/// Rotation from the principal frame of a body to the world.
Quat principal_to_world(const BodyStore& bodies, std::size_t i);

/// Inverse inertia in the world frame, 1/(kg m^2), symmetric; zero for static bodies.
Mat3 inverse_inertia_world(const BodyStore& bodies, std::size_t i);

/// Inertia in the world frame, kg m^2; zero for static bodies.
Mat3 inertia_world(const BodyStore& bodies, std::size_t i);

}  // namespace poise::dynamics
