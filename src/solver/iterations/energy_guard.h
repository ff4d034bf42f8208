// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solver/contacts/contact_lanes.h"
#include "solver/contacts/split_system.h"
#include "solver/iterations/energy_lanes.h"

namespace poise::solver {

/// Kinetic energy of the bodies in contact while the solver iterates. Inelastic contacts add no energy, and neither
/// does a plain iteration: a gain is the sign of an extrapolation step that diverged. Invariant: buffers only grow.
class EnergyGuard {
 public:
  /// Before forces act on `system`.
  void begin(const SplitSystem& system, std::span<const ContactBlock> blocks);
  /// Joules, with these changes on top of the velocities at the start of the step.
  [[nodiscard]] double joules(std::span<const MotionChange<double>> changes) const;
  /// The same with what the accelerations add in `h_s`, and no contact.
  [[nodiscard]] double joules_alone(const SplitSystem& system, std::span<const SpeedChange<double>> begun,
                                    double h_s) const;

  /// What share of the impulses takes most energy from the bodies, at most all: with `changes` they have all, with
  /// `begun` and what accelerations add in `h_s`, none. It is 1 for the answer itself, where no place parts under its
  /// load. All of them where something moves that has no mass: what it pushes gains energy rightly.
  [[nodiscard]] double best_share(const SplitSystem& system, std::span<const SpeedChange<double>> begun, double h_s,
                                  std::span<const MotionChange<double>> changes) const;
  /// Leaves the bodies with this share.
  void scale(const SplitSystem& system, std::span<const SpeedChange<double>> begun, double h_s, double share,
             std::span<MotionChange<double>> changes) const;

  /// Saves the velocities of these bodies; `restore` brings them back to the bit.
  void keep(std::span<const MotionChange<double>> changes);
  void restore(std::span<MotionChange<double>> changes) const;

 private:
  struct Body {
    std::uint32_t name = 0;
    double kg = 0;
    Mat3 inertia_kgm2 = Mat3::Zero();
    Vec3 velocity_mps = Vec3::Zero(), spin_radps = Vec3::Zero();
  };
  struct Speed {
    Vec3 velocity_mps, spin_radps;
  };
  void fill_lanes();
  template <class Change>
  static Speed speed(const Body& body, const Change& change);
  static Speed speed_alone(const SplitSystem& system, const Body& body, const SpeedChange<double>& begun, double h_s);
  static double product(const Body& body, const Speed& a, const Speed& b);

  std::vector<std::uint32_t> names_;
  std::vector<Body> bodies_;
  std::vector<BodyEnergies> lanes_;  // the same, for joules()
  bool driven_ = false;              // by a body without mass that moves: it may give them any energy
  std::vector<MotionChange<double>> saved_;
};

}  // namespace poise::solver
